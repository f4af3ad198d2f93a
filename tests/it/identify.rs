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
    let printed: Json = serde_json::from_str(&folder.good(&command)).expect("JSON");
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
