//! `trocar identify`: the files, and errors with their remedies.

use serde_json::Value as Json;

use crate::support::test_folder::TestFolder;

const COLUMNS: [&str; 8] = ["--time", "t", "--master", "m", "--slave", "s", "--force", "f"];

/// Writes a slave that follows its master 10 ms later, with a force that does not act on it.
fn machine(folder: &TestFolder, name: &str, row: impl Fn(usize, f64, f64, f64) -> String) {
    let rows = (0..1200).map(|k| {
        let place = |t: f64| 0.01 * (9.0 * t).sin();
        let t = k as f64 * 1e-3;
        let slave = place(t - 0.01);
        format!("{t:.3},{}\n", row(k, place(t), slave, 300.0 * slave.max(0.0)))
    });
    folder.file(name, std::iter::once("t,m,s,f\n".to_owned()).chain(rows).collect::<String>());
}

fn good(_: usize, master: f64, slave: f64, force: f64) -> String {
    format!("{master:.7},{slave:.7},{force:.5}")
}

#[test]
fn parameters_and_fits_are_printed_and_written() {
    let folder = TestFolder::new();
    machine(&folder, "train.csv", good);
    machine(&folder, "other.csv", good);
    let command =
        [&["identify", "train.csv", "--predict", "other.csv", "--no-figures", "--json"][..], &COLUMNS].concat();
    let printed = folder.json(&command);
    let roles: Vec<&str> = (0..2).filter_map(|k| printed["fits"][k]["role"].as_str()).collect();
    assert_eq!(roles, ["training", "prediction"]);
    assert!(printed["fits"][1]["fit_percent"].as_f64().is_some_and(|fit| fit > 99.0), "{printed}");
    let gain = &printed["parameters"]["position_gain_n_per_m"];
    // The force does not move this slave, so that only ratios are known.
    assert_eq!((&printed["only_ratios"], &gain["unit"]), (&true.into(), &"N/m per kg".into()));
    assert!(!folder.path("out/train/slave.toml").exists(), "ratios are no forces");
    let toml: toml::Table = folder.text("out/train/machine.toml").parse().expect("TOML");
    assert_eq!(toml["machine"]["slave"]["position_gain_n_per_m"].as_float(), gain["value"].as_f64());
}

/// Writes a slave of 0.4 kg with friction that follows its master against a spring of 300 N/m.
fn slave_on_spring(folder: &TestFolder, name: &str) {
    const STEP_S: f64 = 1e-5;
    let mut text = String::from("t,m,s,f\n");
    let (mut x, mut v) = (0.0_f64, 0.0_f64);
    for k in 0..300_000 {
        let t = STEP_S * f64::from(k);
        let place = |t: f64| 0.012 * (7.0 * t).sin() + 0.006 * (19.0 * t).sin();
        let (master, speed) = (place(t), (place(t + 1e-6) - place(t - 1e-6)) / 2e-6);
        let force = 300.0 * x.max(0.0);
        if k % 100 == 0 {
            text += &format!("{t:.3},{master:.9},{x:.9},{force:.7}\n");
        }
        let other = 400.0 * (master - x) + 6.0 * (speed - v) - 3.0 * v - force;
        let friction = if v.abs() < 1e-5 { other.clamp(-0.3, 0.3) } else { 0.3 * v.signum() };
        v += STEP_S * (other - friction) / 0.4;
        x += STEP_S * v;
    }
    folder.file(name, text);
}

#[test]
fn the_identified_slave_is_a_scenario_that_runs() {
    let folder = TestFolder::new();
    slave_on_spring(&folder, "train.csv");
    folder.good(&[&["identify", "train.csv", "--no-figures"][..], &COLUMNS].concat());
    let scenario: toml::Table = folder.text("out/train/slave.toml").parse().expect("TOML");
    let value = |key: &str| scenario["slave"][key].as_float().expect("a number");
    for (key, expected) in [
        ("mass_kg", 0.4),
        ("damping_n_s_per_m", 3.0),
        ("coulomb_friction_n", 0.3),
        ("proportional_gain", 400.0),
        ("derivative_gain", 6.0),
    ] {
        assert!((value(key) / expected - 1.0).abs() < 0.1, "{key}: {} {expected}", value(key));
    }
    folder.good(&["run", "out/train/slave.toml", "--no-figures", "--set", "simulation.duration_s=1"]);
    let twin: toml::Table = folder.text("out/train/twin.toml").parse().expect("TOML");
    let mass = &twin["axes"]["slave"]["mass_kg"];
    let [low, high] = ["from", "to"].map(|end| mass[end].as_float().expect("a number"));
    let value = scenario["slave"]["mass_kg"].as_float().expect("a number");
    assert!(low < value && value < high, "{low} {value} {high}");
    folder.good(&["sweep", "out/train/twin.toml", "--set", "simulation.duration_s=1", "--out", "twin"]);
}

#[test]
fn recordings_that_cannot_be_used_are_refused_with_a_remedy() {
    let folder = TestFolder::new();
    machine(&folder, "nan.csv", |k, m, s, f| if k == 7 { format!("{m:.7},nan,0") } else { good(k, m, s, f) });
    machine(&folder, "still.csv", |_, _, _, _| "0,0,0".into());
    machine(&folder, "uneven.csv", |k, m, s, f| if k == 9 { format!("{m:.7},{s:.7}") } else { good(k, m, s, f) });
    for (file, phrases) in [
        ("nan.csv", ["line 9", "remove the row"]),
        ("still.csv", ["the master does not move", "record a motion"]),
        ("uneven.csv", ["line 11", "complete or remove the row"]),
    ] {
        folder.refused(&[&["identify", file][..], &COLUMNS].concat(), &phrases);
    }
}

#[test]
fn a_master_in_millimetres_is_reported() {
    let folder = TestFolder::new();
    machine(&folder, "mm.csv", |k, m, s, f| good(k, 1e3 * m, s, f));
    let output = folder.trocar(&[&["identify", "mm.csv", "--no-figures", "--deny-warnings"][..], &COLUMNS].concat());
    assert!(output.err.contains("the slave's motion is 1.000e-3 times"), "{}", output.err);
}

/// Writes a needle that moves in and out of 400 N/m and 6 N·s/m from 2 mm on; a row is a function of time, position and
/// force.
fn insertion(folder: &TestFolder, name: &str, header: &str, row: impl Fn(usize, f64, f64) -> String) {
    let rows = (0..3000).map(|k| {
        let t = k as f64 * 1e-3;
        let (x, v) =
            (0.01 * (6.0 * t).sin() + 0.002 * (17.0 * t).sin(), 0.06 * (6.0 * t).cos() + 0.034 * (17.0 * t).cos());
        let force = if x > 0.002 { 400.0 * (x - 0.002) + 6.0 * v } else { 0.0 };
        format!("{}\n", row(k, x, force + 0.005 * (k as f64 * 1.7).sin()))
    });
    folder.file(name, std::iter::once(format!("{header}\n")).chain(rows).collect::<String>());
}

fn plain(k: usize, x: f64, force: f64) -> String {
    format!("{:.3},{x:.7},{force:.6}", k as f64 * 1e-3)
}

const TISSUE: [&str; 8] = ["--machine", "tissue", "--time", "t", "--slave", "x", "--force", "f"];

#[test]
fn the_identified_tissue_is_a_scenario_that_runs() {
    let folder = TestFolder::new();
    insertion(&folder, "train.csv", "t,x,f", plain);
    insertion(&folder, "other.csv", "t,x,f", plain);
    let command = [&["identify", "train.csv", "--predict", "other.csv", "--json"][..], &TISSUE].concat();
    let printed = folder.json(&command);
    assert_eq!((&printed["machine"], &printed["structure"]), (&"tissue".into(), &"kelvin-voigt".into()), "{printed}");
    for (key, truth, unit) in
        [("stiffness_n_per_m", 400.0, "N/m"), ("damping_n_s_per_m", 6.0, "N·s/m"), ("contact_m", 0.002, "m")]
    {
        let one = &printed["parameters"][key];
        let value = one["value"].as_f64().expect("a number");
        assert!((value / truth - 1.0).abs() < 0.02, "{key}: {one}");
        assert!(one["low"].as_f64() < Some(value) && Some(value) < one["high"].as_f64(), "{key}: {one}");
        assert_eq!(one["unit"], unit);
    }
    assert_eq!(printed["fits"][1]["role"], "prediction");
    assert!(printed["fits"][1]["fit_percent"].as_f64().is_some_and(|fit| fit > 99.0), "{printed}");
    assert!(folder.path("out/train/other.svg").exists(), "measured against predicted is drawn");
    folder.good(&["run", "out/train/tissue.toml", "--no-figures", "--set", "simulation.duration_s=1"]);
}

#[test]
fn the_identified_arm_is_a_scenario_that_runs_and_a_master_is_written() {
    let folder = TestFolder::new();
    // A hand of 300 N/m and 10 N·s/m that follows a desired motion, and pushes a mass of 0.4 kg with friction.
    let mut text = String::from("t,x,f,d\n");
    let (mut x, mut v) = (0.0_f64, 0.0_f64);
    for k in 0..300_000 {
        let t = 1e-5 * f64::from(k);
        let wave = |t: f64| 0.02 * (7.0 * t).sin() + 0.006 * (23.0 * t).sin();
        let (desired, rate) = (wave(t), (wave(t + 1e-6) - wave(t - 1e-6)) / 2e-6);
        let hand = 300.0 * (desired - x) + 10.0 * (rate - v);
        if k % 100 == 0 {
            text += &format!("{t:.3},{x:.8},{hand:.6},{desired:.8}\n");
        }
        let impulse = 0.4 * v / 1e-5 + hand;
        v = (impulse - impulse.clamp(-0.5, 0.5)) / (0.4 / 1e-5 + 2.0);
        x += 1e-5 * v;
    }
    folder.file("hand.csv", text);
    let columns = ["--time", "t", "--master", "x", "--force", "f", "--no-figures", "--json"];
    let identify = |machine: &[&str]| folder.json(&[&["identify", "hand.csv"][..], machine, &columns].concat());
    let close = |printed: &Json, key: &str, truth: f64| {
        let value = printed["parameters"][key]["value"].as_f64().unwrap_or_default();
        assert!((value / truth - 1.0).abs() < 0.05, "{key}: {value} {printed}");
    };
    let arm = identify(&["--machine", "arm", "--desired", "d"]);
    close(&arm, "static_stiffness_n_per_m", 300.0);
    assert!(arm["open"].to_string().contains("cannot tell the spring at the hand"), "{arm}");
    folder.good(&["run", "out/hand/arm.toml", "--no-figures", "--set", "simulation.duration_s=1"]);
    let master = identify(&["--machine", "master"]);
    for (key, truth) in [("mass_kg", 0.4), ("viscous_n_s_per_m", 2.0), ("coulomb_n", 0.5)] {
        close(&master, key, truth);
    }
    let scenario: toml::Table = folder.text("out/hand/master.toml").parse().expect("TOML");
    assert_eq!(scenario["master"]["model"].as_str(), Some("mass-damper"));
    assert_eq!(scenario["master"]["mass_kg"].as_float(), master["parameters"]["mass_kg"]["value"].as_f64());
}

#[test]
fn recordings_of_a_tissue_that_cannot_be_used_are_refused_with_a_remedy() {
    let folder = TestFolder::new();
    let write = |name: &str, row: &dyn Fn(usize, f64, f64) -> String| insertion(&folder, name, "t,x,f", row);
    write("good.csv", &plain);
    write("nan.csv", &|k, x, f| if k == 7 { format!("{k},nan,0") } else { plain(k, x, f) });
    write("uneven.csv", &|k, x, f| if k == 9 { "0.009,0.001".into() } else { plain(k, x, f) });
    write("still.csv", &|k, _, f| plain(k, 0.0, f));
    write("silent.csv", &|k, x, _| plain(k, x, 0.0));
    write("air.csv", &|k, x, _| plain(k, x, 0.01 * (k as f64 * 1.7).sin()));
    write("pulled.csv", &|k, x, f| plain(k, x, -f));
    folder.file("short.csv", "t,x,f\n0,0,0\n0.001,0.1,1\n0.002,0.2,2\n");
    for (file, phrases) in [
        ("nan.csv", ["line 9", "remove the row"]),
        ("uneven.csv", ["line 11", "complete or remove the row"]),
        ("still.csv", ["the slave does not move", "record a motion"]),
        ("silent.csv", ["the force does not change", "check --force"]),
        ("air.csv", ["no contact", "record an insertion"]),
        ("pulled.csv", ["no contact", "check the signs"]),
        ("short.csv", ["3 samples", "record longer"]),
    ] {
        folder.refused(&[&["identify", file][..], &TISSUE].concat(), &phrases);
    }
    let other = |machine: &'static str, position: &'static str, force: &'static str| {
        ["identify", "good.csv", "--time", "t", "--machine", machine, position, "x", "--force", force]
    };
    folder.refused(&other("tissue", "--slave", "g"), &["no column", "g"]);
    folder.refused(
        &other("tissue", "--master", "f"),
        &["--master is not used to identify the tissue", "another --machine"],
    );
    folder.refused(&other("arm", "--slave", "f"), &["--slave is not used to identify the arm", "another --machine"]);
    folder.refused(&other("slave", "--slave", "f"), &["to identify the slave, --master is needed", "give its column"]);
    // The hand of these recordings pushes the master away from the position that it is to have.
    folder.refused(&other("arm", "--master", "f"), &["does not pull the master", "check the sign of --force"]);
}

#[test]
fn a_needle_in_millimetres_and_forces_in_millinewtons_are_reported() {
    let folder = TestFolder::new();
    insertion(&folder, "mm.csv", "t,x,f", |k, x, f| plain(k, 1e3 * x, f));
    insertion(&folder, "mn.csv", "t,x,f", |k, x, f| plain(k, x, 1e3 * f));
    for (file, phrase) in [("mm.csv", "the slave moves by"), ("mn.csv", "the largest force is")] {
        let output = folder.trocar(&[&["identify", file, "--no-figures", "--deny-warnings"][..], &TISSUE].concat());
        assert!(output.err.contains(phrase), "{}", output.err);
    }
}
