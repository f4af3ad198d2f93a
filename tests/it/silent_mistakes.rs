//! Mistakes that change results without an error: each gives a warning, and correct inputs give none.

use std::fmt::Write as _;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use trocar::scenario::shipped_questions;

use crate::support::test_folder::{TestFolder, words};

/// Returns an insertion at 10 mm/s and 1 kHz: free motion, a spring from 0 on, a rupture at 2.5 s and 15 mm, and a
/// softer spring.
fn insertion(offset_n: f64) -> String {
    let mut random = ChaCha8Rng::seed_from_u64(7);
    let mut text = "time_s,position_m,force_n\n".to_owned();
    for k in 0..5000 {
        let time_s = f64::from(k) * 1e-3;
        let position_m = -0.01 + 0.01 * time_s;
        let force_n = match position_m {
            x if x <= 0.0 => 0.0,
            x if x <= 0.015 => 300.0 * x,
            x => 1.0 + 100.0 * (x - 0.015),
        };
        let noise_n = 0.01 * (random.random::<f64>() + random.random::<f64>() - 1.0);
        let _ = writeln!(text, "{time_s:.3},{position_m:.7},{:.5}", force_n + noise_n + offset_n);
    }
    text
}

fn folder() -> TestFolder {
    let folder = TestFolder::new();
    folder.file("good.csv", insertion(0.0)).file("untared.csv", insertion(0.35));
    folder
}

/// Returns the codes of a command's warnings, and the words on standard error.
fn warned(folder: &TestFolder, command: &str) -> (Vec<String>, String) {
    let printed = folder.warned(&command.split(' ').collect::<Vec<_>>());
    let code = |line: &str| Some(line.strip_prefix("warning[")?.split(']').next()?.to_owned());
    (printed.lines().filter_map(code).collect(), words(&printed))
}

#[track_caller]
fn assert_warns(folder: &TestFolder, command: &str, code: &str, phrases: &[&str]) {
    let (codes, text) = warned(folder, command);
    assert!(codes.iter().any(|found| found == code), "{command}: no {code} in {text}");
    for phrase in phrases {
        assert!(text.contains(phrase), "{command}: no {phrase:?} in {text}");
    }
    assert!(text.contains("help: "), "{text}");
}

#[track_caller]
fn assert_silent(folder: &TestFolder, command: &str, code: &str) {
    let (codes, text) = warned(folder, command);
    assert!(!codes.contains(&code.to_owned()), "{command}: {text}");
}

#[test]
fn a_force_in_the_wrong_unit_gives_a_warning() {
    let folder = folder();
    let phrases = ["the force stays within", "needle insertions reach at least 0.1 N", "check the unit of the force"];
    for command in ["detect", "calibrate"] {
        let millinewtons = format!("{command} good.csv --force force_n:mN");
        assert_warns(&folder, &millinewtons, "force-magnitude", &phrases);
    }
    let small = "run paper/real-classical --set recording.scale.force_n=0.0133";
    assert_warns(&folder, small, "force-magnitude", &phrases[..2]);
}

#[test]
fn an_offset_of_the_force_gives_a_warning_and_can_be_tared() {
    let folder = folder();
    let phrases = ["the force stays at 0.350 N, which is not 0", "not to be tared", "--tare-s 0.499"];
    for command in ["detect", "calibrate"] {
        assert_warns(&folder, &format!("{command} untared.csv"), "force-offset", &phrases);
        assert_eq!(warned(&folder, &format!("{command} untared.csv --tare-s 0.5")).0, [""; 0], "{command}");
        assert_eq!(warned(&folder, &format!("{command} good.csv")).0, [""; 0], "{command}");
    }
    // The calibrated settings include the tare, and both recordings give the same settings.
    let calibrated = |name: &str, tare: &[&str]| {
        folder.good(&[&["calibrate", name, "--out", &format!("of-{name}")][..], tare].concat());
        let text = folder.text(&format!("of-{name}/{}/calibrated.toml", name.trim_end_matches(".csv")));
        let number = |key: &str| -> f64 {
            let line = text.lines().find_map(|line| line.strip_prefix(key)?.trim().strip_prefix("= ")).expect(key);
            line.parse().expect("a number")
        };
        assert_eq!(text.contains("tare_s = 0.5"), !tare.is_empty(), "{text}");
        [number("contact_m"), number("threshold")]
    };
    let (good, tared) = (calibrated("good.csv", &[]), calibrated("untared.csv", &["--tare-s", "0.5"]));
    assert!((good[0] - tared[0]).abs() < 2e-4 && (good[1] / tared[1] - 1.0).abs() < 0.2, "{good:?} {tared:?}");
    folder.refused(
        &["detect", "good.csv", "--tare-s", "5"],
        &["recording.tare_s is 5 s", "below the length", "help: give the time"],
    );
}

#[test]
#[ignore = "more than 5 s of processor time"]
fn a_run_that_is_too_short_gives_a_warning() {
    let folder = folder();
    let skin = "layers/through-the-skin";
    for (scenario, settings, code, phrases) in [
        (
            skin,
            "tissue.contact_m=25",
            "tissue-not-touched",
            &["the needle never touches the tissue", "the surface is at 25000.00 mm", "as in \"25mm\""][..],
        ),
        (
            skin,
            "operator.movement_s=5000",
            "motion-beyond-run",
            &["the operator's movement takes 5000 s and the run lasts", "lengthen simulation.duration_s"],
        ),
        (
            skin,
            "operator.kind=ramp --set operator.speed_m_per_s=1e-4",
            "motion-beyond-run",
            &["operator.speed_m_per_s in m/s"],
        ),
        (
            skin,
            "operator.end_m=50mm",
            "layer-not-ruptured",
            &[
                "the layer capsule does not rupture: 2 of 3 layers do",
                "it ruptures at 1.6 N",
                "help: move the operator further",
            ],
        ),
        (
            skin,
            "tissue.layer.capsule.rupture_force_n=60",
            "layer-not-ruptured",
            &["the layer capsule does not rupture", "it ruptures at 60 N"],
        ),
        (
            "paper/classical",
            "simulation.duration_s=6",
            "layer-not-ruptured",
            &["the rupture that is labelled at 8.85 s is not in the run, which ends at 6 s"],
        ),
        (
            "paper/depth-classical",
            "operator.end_m=10mm",
            "layer-not-ruptured",
            &["the needle does not reach the rupture at"],
        ),
    ] {
        assert_warns(&folder, &format!("run {scenario} --set {settings}"), code, phrases);
    }
    // A check foresees the problem, and the verdict of a run reports it.
    let (codes, _) = warned(&folder, &format!("check {skin} --set operator.movement_s=5000"));
    assert_eq!(codes, ["motion-beyond-run"]);
    let output = |settings: &str| folder.said(&["run", skin, "--set", settings]);
    assert!(output("tissue.contact_m=25").contains("The needle never touches the tissue."));
    assert!(output("operator.end_m=50mm").contains("The layer capsule does not rupture."));
}

#[test]
fn a_layer_to_be_spared_gives_no_warning() {
    let folder = folder();
    let spared = "run layers/through-the-skin --set operator.end_m=50mm --set tissue.spared_layer=capsule";
    assert_silent(&folder, spared, "layer-not-ruptured");
    folder.refused(
        &["run", "layers/through-the-skin", "--set", "tissue.spared_layer=capsul"],
        &["tissue.spared_layer is \"capsul\", and no layer of this name ruptures", "did you mean capsule?"],
    );
}

#[test]
fn a_stray_alarm_does_not_count_as_a_detection() {
    let folder = folder();
    // The recording of the tutorial, replayed with the base's force scale of 1. The loop is far too strongly coupled.
    folder.file(
        "strong.toml",
        "name = \"strong\"\nbase = \"paper/augmented\"\n[recording]\nfile = \"builtin:own_ctrl_pop.csv\"\nruptures_s = [1.779]\n\
         [recording.columns]\ntime_s = \"t_s\"\nposition_m = \"xs_rad\"\nvelocity_m_per_s = \"vs_rad_s\"\n\
         force_n = \"env_out_Nm_derived\"\n[recording.scale]\nposition_m = 0.075\nvelocity_m_per_s = 0.075\n\
         force_n = 13.333333\n[estimator]\ncontact_m = 0.0063\n",
    );
    let phrases =
        ["the alarm at 2.266 s comes 487.0 ms after rupture 1 at 1.779 s and is not its detection", "within 100 ms"];
    assert_warns(&folder, "run strong.toml", "stray-alarm", &phrases);
    let said = folder.said(&["run", "strong.toml"]);
    assert!(said.contains("1 of 1 rupture is missed") && !said.contains("detects every rupture"), "{said}");
    // The trace of this run as a recording, with the same label.
    let trace = "detect out/strong/trace.csv --position slave_position_m --force measured_force_n --contact-m 0.0063 \
                 --set detector.distance=squared-residual --rupture-s 1.779";
    let phrases = [
        "alarm 1 at 2.266 s comes 487.0 ms after the labelled rupture 1 at 1.779 s and is not its detection",
        "the force does not fall within 0.1 s before it",
    ];
    assert_warns(&folder, trace, "stray-alarm", &phrases);
    let said = folder.said(&trace.split(' ').collect::<Vec<_>>());
    assert!(said.contains("1 of 1 labelled rupture missed, 1 false alarm."), "{said}");
    let good = folder.said(&["detect", "good.csv", "--rupture-s", "2.49"]);
    assert!(good.contains("0 of 1 labelled rupture missed, 0 false"), "{good}");
}

#[test]
#[ignore = "more than 5 s of processor time"]
fn a_key_without_effect_gives_a_warning() {
    let folder = folder();
    let unread = "key-without-effect";
    for (command, phrases) in [
        (
            "detect good.csv --set sensor.force_bias_n=-0.35",
            &["sensor.force_bias_n changes nothing here", "simulated sensor", "--tare-s"][..],
        ),
        (
            "detect paper/real-classical --set operator.kind=ramp",
            &["operator.kind changes nothing here: a recording is not simulated"],
        ),
        (
            "calibrate good.csv --set detector.threshold=1",
            &["detector.threshold changes nothing here: a calibration computes it"],
        ),
        ("detect good.csv --set detector.insertion_speed_m_per_s=0.01", &["it acts for detector.motion = inserting"]),
        (
            "stability layers/through-the-skin --set detector.threshold=1",
            &["detector.threshold changes nothing here: the linear loop has no detection"],
        ),
    ] {
        assert_warns(&folder, command, unread, phrases);
    }
    for good in [
        "detect good.csv --set detector.threshold=1",
        "detect good.csv --set sensor.position_resolution_m=1e-7",
        "calibrate good.csv --set estimator.contact_m=0",
        "stability layers/through-the-skin --set scaling.force=0.5",
    ] {
        assert_silent(&folder, good, unread);
    }
}

#[test]
fn a_delay_that_is_rounded_to_whole_ticks_gives_a_warning() {
    let folder = folder();
    let sampled = "run link/long-delay --set simulation.control=sampled --set channel.delay_s=19.1ms";
    let phrases =
        ["channel.delay_s is 19.10 ms and acts as 20.00 ms", "sampled controllers", "multiple of simulation.tick_s"];
    assert_warns(&folder, sampled, "delay-rounded", &phrases);
    let other = "run link/four-channel --set channel.delay_s=19.1ms";
    assert_warns(&folder, other, "delay-rounded", &["this architecture or passivity scheme computes on the tick"]);
    // A compliant slave reads a sample on arrival, like a slave without compliance.
    let yields = "run link/long-delay --set slave.compliance_m_per_n=1e-4 --set channel.delay_s=19.1ms";
    assert_silent(&folder, yields, "delay-rounded");
}

#[test]
fn the_error_of_a_bad_sample_is_reported_with_guessed_columns() {
    let folder = TestFolder::new();
    let rows = |bad: &str| {
        let row = |k: u32| {
            format!("{:.3};{:.2};{:.1}", f64::from(k) * 0.002, -5.0 + 0.02 * f64::from(k), 0.1 * f64::from(k % 7))
        };
        let mut rows: Vec<String> = (0..900).map(|k| row(k).replace('.', ",")).collect();
        rows[701] = bad.to_owned();
        format!("Zeit [s];Weg [mm];Kraft [N]\n{}\n", rows.join("\n"))
    };
    for (bad, phrases) in [
        ("1,4;9,02;0,1", ["the time 1.4 s repeats that of line 702", "line 703"]),
        ("1,402;9,02;NaN", ["column 'Kraft [N]': 'NaN' is not finite", "line 703"]),
        ("1,402;9,02;", ["column 'Kraft [N]': the field is empty", "line 703"]),
        ("1,402;9,02", ["the row has 2 fields, the header 3", "line 703"]),
        ("1,402;1.009,02;0,1", ["'1.009,02' is not a number; write it without thousands separators", "line 703"]),
        ("1,402;9.02;0,1", ["'9.02' and earlier numbers mix decimal points and decimal commas", "line 703"]),
        ("1,402;abc;0,1", ["'abc' is not a number; correct it or remove the row", "line 703"]),
    ] {
        folder.file("bad.csv", rows(bad));
        folder.refused(&["detect", "bad.csv"], &phrases);
        folder.refused(&["calibrate", "bad.csv"], &phrases);
    }
}

#[test]
fn explain_knows_labels_and_sections() {
    let folder = TestFolder::new();
    let explained = |word: &str| folder.good(&["explain", word]);
    assert!(explained("depth 2 s later").contains("rupture_1_horizon_advance_m"));
    assert!(explained("rupture 2: detection delay").contains("rupture_1_detection_delay_s"));
    assert!(explained("Mean |residual|").contains("In tables: mean |residual|."));
    let operator = explained("operator");
    assert!(operator.contains("operator.movement_s") && operator.contains("[operator]"), "{operator}");
    assert!(explained("stability").contains("stability_"));
}

/// The shipped scenarios give only the warnings that they demonstrate.
#[test]
#[ignore = "more than 5 s of processor time"]
fn correct_inputs_give_no_warning() {
    let folder = TestFolder::new();
    let new = [
        "force-offset",
        "force-magnitude",
        "key-without-effect",
        "delay-rounded",
        "tissue-not-touched",
        "motion-beyond-run",
        "stray-alarm",
    ];
    // Strategies that end the insertion before the capsule, and a hand that is too fast.
    let unruptured = [
        "hand/fast-stab",
        "strategies/clutch",
        "strategies/forbidden-region",
        "strategies/ramp-until-load",
        "strategies/fade",
        "strategies/when-still",
    ];
    for (name, _) in shipped_questions() {
        let name = name.trim_end_matches(".toml");
        // It ends while the needle is drawn back, before the second layer.
        if name == "paper/depth-swing" {
            continue;
        }
        let (codes, text) = warned(&folder, &format!("run {name} --out runs"));
        assert!(codes.iter().all(|code| !new.contains(&code.as_str())), "{name}: {text}");
        assert_eq!(codes.contains(&"layer-not-ruptured".to_owned()), unruptured.contains(&name), "{name}: {text}");
    }
}
