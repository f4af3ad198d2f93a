//! The command line: exit codes, messages with place and remedy, complete and reproducible files.

use std::fs;
use std::path::Path;

use crate::support::test_folder::{TestFolder, words};
use crate::support::{assert_file, file};

const SHORT: &str =
    "name = \"short\"\noperator.kind = \"ramp\"\ntissue.kind = \"kelvin-voigt\"\nsimulation.duration_s = 0.5\n";

#[test]
fn the_same_scenario_gives_the_same_bytes_and_so_does_its_echo() {
    let folder = TestFolder::new();
    let noise = "sensor.force_noise_std_n=0.02";
    for out in ["one", "two"] {
        folder.good(&["run", "paper/augmented", "--quiet", "--set", noise, "--out", out]);
    }
    folder.good(&["run", "one/augmented/scenario.toml", "--quiet", "--out", "three"]);
    let one = folder.files("one");
    assert_eq!(one.len(), 16, "{:?}", one.keys());
    for again in ["two", "three"] {
        let again = folder.files(again);
        for (path, content) in &one {
            assert!(again.get(path) == Some(content), "{} differs", path.display());
        }
    }
}

#[test]
fn a_bad_key_is_underlined_and_named() {
    let folder = TestFolder::new();
    let cases = [
        "[slave]\nvelocty_gain = 2",
        "[slave]\nvelocity_gain = \"2\"",
        "[master]\nmass_kg = -1",
        "[master]\nmass_kg = nan",
        "simulation.tick_s = 0",
        "simulation.tick_s = 1e-12",
        "simulation.tick_s = inf",
        "[slave]\ndamping = \"velocty\"",
        "[detector]\ncap = 1e-3",
        "[estimator]\nreset_threshold = 1e-9",
        "[augmentation]\nmax_hold_s = 0.1",
        "[slave]\ndenominator = [1.0, 2.0]",
        "slave = 3",
        "[slave\nvelocity_gain = 2",
        "[slvae]",
        "slave.velocity_gain = {}",
        "\"slave.velocity_gain\" = 3",
        "operator.start_m = 2.0",
        "[a]\nb.c.d = 2",
        "operator.end_m = 1e6",
        "channel.forward_delay_s = \"30mm\"",
        "channel.forward_delay_s = \"300xf\"",
        "simulation.seed = 12345678901234567890",
        "[[tissue.layers]]\nname = \"skin\"",
        "tissue.membrane = 3",
        "tissue.membrane.thickness_m = 1",
        "tissue.skn.thickness_m = 1",
        "tissue.kind = \"layers\"\nsimulation.tick_s = 1",
        "scaling.position = -1\nslave.velocty_gain = 2\nchannel.forward_delay_s = -1",
    ];
    let message = |lines: &str| {
        // A file cannot contain a key twice.
        let short = if lines.starts_with("tissue.kind") { "operator.kind = \"ramp\"\n" } else { SHORT };
        folder.file("bad.toml", format!("{short}\n{lines}\n"));
        let message = folder.refusal(&["check", "bad.toml"]);
        for command in ["run", "compare"] {
            assert_eq!(folder.refusal(&[command, "bad.toml"]), message);
        }
        format!("{lines}\n\n{message}\n")
    };
    assert_file("tests/it/snapshots/bad_keys.txt", &cases.map(message).concat());
}

#[test]
fn bases_are_resolved_and_cycles_are_refused() {
    let folder = TestFolder::new();
    folder
        .file("base.toml", SHORT)
        .file("deep/child.toml", "base = \"../base.toml\"\nname = \"child\"\nscaling.force = 2.0\n");
    let resolved = folder.good(&["check", "deep/child.toml", "--resolved", "--set", "scaling.position=0.5"]);
    for line in ["name = \"child\"", "force = 2.0", "position = 0.5", "duration_s = 0.5"] {
        assert!(resolved.lines().any(|found| found == line), "{line} in\n{resolved}");
    }
    folder.file("y.toml", "\nbase = \"./x.toml\"\n");
    for (base, phrases) in [
        ("\"x.toml\"", ["based on itself", "x.toml:1:8"]),
        ("\"y.toml\"", ["based on itself", "y.toml:2:8"]),
        ("\"none.toml\"", ["none.toml", "x.toml:1:8"]),
        ("3", ["base is 3", "path of a scenario"]),
    ] {
        folder.file("x.toml", format!("base = {base}\n")).refused(&["run", "x.toml"], &phrases);
    }
}

#[test]
fn settings_are_checked_like_files() {
    let folder = TestFolder::new();
    folder.file("a.toml", SHORT);
    let commands = "
        run a.toml --set scaling.force
        run a.toml --set scaling.forse=2
        run a.toml --set scaling.force=-2
        run a.toml --set name=../up
        run a.toml a.toml
        run none.toml
        sweep none.toml
        run a.toml --set simulation.seed=12345678901234567890
        run builtin:none.toml
        run
        swim";
    assert_file("tests/it/snapshots/bad_settings.txt", &folder.refusals(commands));
    folder.refused(&["compare", "a.toml", "--set", "name=report.html"], &["report.html"]);
}

#[test]
fn a_file_with_many_errors_shows_twenty_and_counts_the_others() {
    let folder = TestFolder::new();
    let keys = (0..24).map(|key| format!("key_{key:02} = 1\n")).collect::<String>();
    let refusal = folder.file("bad.toml", format!("{keys}scaling.force = -1\n")).refusal(&["check", "bad.toml"]);
    let named = refusal.lines().filter_map(|line| line.strip_prefix("error: there is no key key_"));
    let expected: Vec<String> = (0..20).map(|key| format!("{key:02}")).collect();
    assert_eq!(named.collect::<Vec<_>>(), expected, "{refusal}");
    assert!(refusal.trim_end().ends_with("error: and 5 more"), "{refusal}");
}

#[test]
fn a_scenario_without_a_recording_says_which_part_replays_one() {
    let folder = TestFolder::new();
    folder.file("layers.toml", "[tissue]\nkind = \"layers\"\n").file("empty.toml", "name = \"empty\"\n");
    let phrases = [
        "layers.toml: operator.kind is \"recording\" (the default), but recording.file is missing",
        "give recording.file, or another operator.kind, e.g. \"minimum-jerk\"",
    ];
    folder.refused(&["check", "layers.toml"], &phrases);
    folder.refused(&["check", "empty.toml"], &["operator.kind is", "and tissue.kind is", "e.g. \"layers\""]);
    folder.refused(&["detect", "layers.toml"], &["recording.file is missing", "path of a CSV file"]);
}

#[test]
fn a_sweep_file_can_be_checked_but_not_run_as_a_scenario() {
    let folder = TestFolder::new();
    folder
        .file("a.toml", SHORT)
        .file("s.toml", "base = \"a.toml\"\n[axes]\nscaling.force = [1.0, 2.0]\nslave.velocity_gain = [14.0, 15.0]\n");
    for command in ["run", "compare"] {
        folder.refused(&[command, "s.toml"], &["s.toml is a sweep file, not a scenario", "`trocar sweep s.toml`"]);
    }
    assert_eq!(
        folder.good(&["check", "s.toml", "a.toml"]),
        "short: valid, 500 ticks of 0.001 s\nlinear loop: stable in contact with 200.0 N/m and 5.000 N·s/m, and out of\n  contact\ns: valid sweep, 4 cases\n"
    );
    assert!(folder.good(&["check", "s.toml", "--resolved"]).contains("velocity_gain"));
    for (base, axis, phrases) in [
        ("a", "scaling.forse = [1.0]", &["there is no key scaling.forse", "did you mean scaling.force?"][..]),
        ("a", "scaling.force = { from = 1.0, to = 2.0, step = 0.5 }", &["a range has no step", "give points instead"]),
        ("none", "scaling.force = [1.0]", &["none.toml", "s.toml:1:8", "relative to the file that contains it"]),
    ] {
        folder.file("s.toml", format!("base = \"{base}.toml\"\n[axes]\n{axis}\n"));
        folder.refused(&["check", "s.toml"], phrases);
    }
}

#[test]
fn a_sweep_names_its_figures() {
    let folder = TestFolder::new();
    folder.file("a.toml", SHORT).file("s.toml", "base = \"a.toml\"\nmetrics = [\"false_alarms\"]\n[axes]\nscaling.force = [1.0, 2.0]\nslave.velocity_gain = [14.0, 15.0]\n");
    for end in ["files: out/s", "already complete: out/s"] {
        let printed = folder.good(&["sweep", "s.toml"]);
        let last: Vec<&str> = printed.lines().rev().take(2).collect();
        assert_eq!(last, [end, "figures: heat_false_alarms.png, tornado.png"], "{printed}");
        assert!(printed.contains("influence of each axis"), "{printed}");
    }
    let heat = folder.text("out/s/heat_false_alarms.svg");
    assert!(heat.contains("false alarms") && !heat.contains("false_alarms"), "the title is the label");
}

#[test]
fn a_missing_column_is_named_with_its_flag() {
    let folder = TestFolder::new();
    let rig = ["detect", "builtin:own_ctrl_pop.csv", "--time", "t_s", "--position", "xs_rad:0.075"];
    let refused = |force: &str, phrases: &[&str]| folder.refused(&[&rig[..], &["--force", force]].concat(), phrases);
    refused("nope", &["no column 'nope' (--force or recording.columns.force_n)", "env_out_Nm_derived"]);
    refused("env_out_Nm", &["t_s, xm_rad, xs_rad, vs_rad_s, env_out_Nm_derived; did you mean 'env_out_Nm_derived'?"]);
    refused(
        "env_out_Nm_derived:lbf",
        &["'lbf' is not a known unit of force; give N, kN, cN, mN, uN, gf or kgf, or a factor into N"],
    );
    refused("env_out_Nm_derived:mm", &["'mm' is not a known unit of force"]);
    folder
        .refused(&["detect", "builtin:own_ctrl_pop.csv"], &["no column 'time_s' (--time or recording.columns.time_s)"]);
    let live = folder.fed(&["detect", "-", "--force", "f:lbf"], b"time_s,position_m,f\n0,0,1\n");
    assert!(live.err.contains("'lbf' is not a known unit of force"), "{}", live.err);
    // A name may contain a colon.
    folder.file("c.csv", "time_s,position_m,f:lbf\n0,0,1\n0.001,0.0001,1\n0.002,0.0002,1\n");
    folder.good(&["detect", "c.csv", "--force", "f:lbf", "--no-figures"]);
    folder.good(&["detect", "c.csv", "--force", "f:lbf:-gf", "--no-figures"]);
    let csv = folder.text("out/c/detection.csv");
    assert!(csv.lines().nth(1).is_some_and(|row| row.split(',').nth(3) == Some("-0.00980665")), "{csv}");
}

#[test]
fn an_inherited_velocity_column_can_be_removed() {
    let folder = TestFolder::new();
    let row = |k: u32| format!("{},{},0.5\n", f64::from(k) * 1e-3, f64::from(k) * 1e-5);
    folder.file("r.csv", format!("time_s,position_m,force_n\n{}", (0..50).map(row).collect::<String>()));
    let scenario = |columns: &str| {
        format!("base = \"paper/augmented\"\n[recording]\nfile = \"r.csv\"\nruptures_s = []\n{columns}")
    };
    folder.file("s.toml", scenario(""));
    let phrase = "no column 'velocity_m_per_s' (--velocity or recording.columns.velocity_m_per_s)";
    folder.refused(&["check", "s.toml"], &[phrase]);
    folder.file("s.toml", scenario("columns.velocity_m_per_s = \"\"\n"));
    let echo = folder.good(&["check", "s.toml", "--resolved"]);
    folder.file("echo.toml", &echo);
    assert_eq!(folder.good(&["check", "echo.toml", "--resolved"]), echo);
    folder.refused(&["check", "s.toml", "--set", "recording.columns.force_n="], &["recording.columns.force_n"]);
}

#[test]
fn calibrate_lists_only_the_first_of_many_alarms() {
    let folder = TestFolder::new();
    // Insertions of two seconds each, with a rupture after one second.
    let mut text = String::from("time_s,position_m,force_n\n");
    for k in 0..40_000 {
        let time_s = 1e-3 * f64::from(k);
        let phase_s = time_s % 2.0;
        let depth_m = 0.02 * phase_s.min(3.0 - 1.5 * phase_s).max(-0.05);
        let stiffness = if phase_s < 1.0 { 400.0 } else { 100.0 };
        let noise_n = 0.04 * (f64::from(k * 7919 % 1000) / 1000.0 - 0.5);
        text += &format!("{time_s:.3},{depth_m:.6},{:.4}\n", stiffness * depth_m.max(0.0) + noise_n);
    }
    folder.file("many.csv", text);
    let printed = folder.good(&["calibrate", "many.csv"]);
    let said = printed.split("with these settings: ").nth(1).expect("the alarms");
    let said = words(said);
    let count: usize = said.split(' ').next().and_then(|count| count.parse().ok()).expect("a number");
    assert!(count > 10, "{said}");
    let (listed, rest) = said.split_once(" and ").expect("more than are listed");
    assert_eq!(listed.matches(" s").count(), 6, "{said}");
    assert!(rest.starts_with(&format!("{} more", count - 6)), "{said}");
}

#[test]
fn a_second_command_keeps_the_files_of_the_first() {
    let recording = "builtin:in_vivo_like.csv";
    let calibrated = ["calibrated.toml", "calibration.json", "calibration/estimation.png"];
    for (first, second, new) in [
        (["detect", recording], &["calibrate", recording, "--first-s", "5"][..], &calibrated[..]),
        (["run", "paper/augmented"], &["detect", "paper/augmented"], &["detection/detection.json"]),
    ] {
        let folder = TestFolder::new();
        folder.good(&[&first[..], &["--out", "out/same"]].concat());
        let mut before = folder.files("out");
        // The manifest of a recording lists the files of both.
        before.retain(|path, _| first[0] == "run" || !path.ends_with("manifest.json"));
        assert!(before.keys().any(|path| path.extension().is_some_and(|extension| extension == "png")));
        folder.good(&[second, &["--out", "out/same"]].concat());
        let after = folder.files("out");
        assert!(before.iter().all(|(path, content)| after.get(path) == Some(content)), "{second:?}");
        for name in new {
            assert!(after.keys().any(|path| path.ends_with(name)), "{name}: {:?}", after.keys());
        }
    }
}

#[test]
fn the_numbers_of_a_calibration_have_at_most_four_digits_and_are_the_same_in_every_file() {
    let folder = TestFolder::new();
    let printed = folder.good(&["calibrate", "builtin:in_vivo_like.csv", "--first-s", "5"]);
    let toml: toml::Table = folder.text("out/in_vivo_like/calibrated.toml").parse().expect("TOML");
    let json: serde_json::Value =
        serde_json::from_str(&folder.text("out/in_vivo_like/calibration.json")).expect("JSON");
    for (section, key) in [
        ("estimator", "reset_threshold"),
        ("estimator", "dead_zone_n"),
        ("estimator", "contact_m"),
        ("detector", "quiet_std_n"),
        ("detector", "threshold"),
        ("detector", "drift"),
        ("detector", "cap"),
    ] {
        let value = toml[section][key].as_float().expect("a number");
        assert_eq!(json["settings"][section][key], value, "{key}");
        assert_eq!(format!("{value:.3e}").parse(), Ok(value), "{key}");
    }
    assert!(printed.contains("above") && printed.contains("of quiet contact"), "{printed}");
}

#[test]
fn a_bad_recording_is_refused_with_the_line() {
    let folder = TestFolder::new();
    let row = |k: u32| format!("{},{},0.5\n", f64::from(k) * 1e-3, f64::from(k) * 1e-5);
    let rows = |range: std::ops::Range<u32>| range.map(row).collect::<String>();
    let head = "time_s,position_m,force_n\n";
    let cases: [(String, &[&str]); 9] = [
        (String::new(), &["holds no data"]),
        (head.to_owned(), &["r.csv"]),
        (format!("{head}{}", row(0)), &["r.csv"]),
        (format!("time_s,position_m,forse_n\n{}", rows(0..9)), &["force_n", "forse_n"]),
        (format!("{head}{}0.009,abc,1\n", rows(0..9)), &["line 11", "position_m", "abc"]),
        (format!("{head}{}0.009,nan,1\n", rows(0..9)), &["line 11", "position_m"]),
        (format!("{head}{}{}", rows(0..9), rows(4..5)), &["line 11"]),
        (format!("{head}{}{}", rows(0..9), rows(400..409)), &["line 11", "max_gap_s"]),
        (format!("{head}{}0.009,1\n", rows(0..9)), &["line 11"]),
    ];
    for (content, phrases) in cases {
        folder.file("r.csv", content).file("s.toml", "recording.file = \"r.csv\"\n");
        // `detect` guesses a column that has another name.
        if !phrases.contains(&"forse_n") {
            folder.refused(&["detect", "r.csv"], phrases);
        }
        folder.refused(&["run", "s.toml"], phrases);
    }
    folder.file("r.csv", format!("{head}{}", rows(0..50)));
    folder.good(&["run", "s.toml"]);
    for limit in ["max_gap_s = 0.0005", "max_bytes = 100", "max_samples = 10"] {
        folder.file("limited.toml", format!("recording.file = \"r.csv\"\nrecording.{limit}\n"));
        folder.refused(&["run", "limited.toml"], &["limited.toml:2", limit]);
    }
    folder.refused(&["run", "s.toml", "--set", "recording.ruptures_s=[0.2]"], &["within the recording"]);
    folder.refused(&["run", "s.toml", "--set", "recording.ruptures_s=[0.02, 0.01]"], &["ascend"]);
    folder.refused(&["detect", "r.csv", "--position", "position_m:0"], &["position_m"]);
    folder.refused(&["detect", "r.csv", "--contact-m", "nan"], &["contact_m"]);
    folder.refused(&["detect", "r.csv", "--rupture-s", "99"], &["within the recording"]);
}

#[test]
fn the_sign_of_a_columns_factor_is_used() {
    let folder = TestFolder::new();
    let row = |k: u32| format!("{},{},{},0.5\n", f64::from(k) * 1e-3, f64::from(k) * 1e-5, 0.01);
    folder.file("r.csv", format!("t,x,v,f\n{}", (0..50).map(row).collect::<String>()));
    for (x, v) in [("x:1", "v:1"), ("x:-1", "v:-1"), ("x:-1", "v:2"), ("x:1", "v:-3")] {
        folder.good(&["detect", "r.csv", "--time", "t", "--position", x, "--velocity", v, "--force", "f:-2"]);
        let csv = fs::read_to_string(folder.path("out/r/detection.csv")).expect("there");
        let last: Vec<f64> =
            csv.lines().last().expect("a row").split(',').map(|f| f.parse().expect("a number")).collect();
        let factor = |column: &str| column[2..].parse::<f64>().expect("a number");
        assert!((last[1] - 49e-5 * factor(x)).abs() < 1e-12 && (last[2] - 0.01 * factor(v)).abs() < 1e-12, "{last:?}");
        assert_eq!(last[3], -1.0);
    }
    folder.refused(
        &["detect", "r.csv", "--time", "t:-1", "--position", "x", "--force", "f"],
        &["recording.scale.time_s"],
    );
    folder.refused(
        &["detect", "r.csv", "--time", "t", "--position", "x", "--force", "f:1e9"],
        &["r.csv line 2, column 'f': is 5e8 N", "the factor of the column"],
    );
}

/// Returns a CSV recording with rows at these times.
fn recording(times_s: impl Iterator<Item = f64>) -> String {
    let mut text = String::from("time_s,position_m,force_n\n");
    for (k, time_s) in times_s.enumerate() {
        text.push_str(&format!("{time_s},{:.5},0.{}\n", k as f64 * 1e-5, 50 + k % 3));
    }
    text
}

/// Returns `count` times, 1 ms apart, from `from_s` on, in s.
fn milliseconds(from_s: f64, count: u32) -> impl Iterator<Item = f64> {
    (0..count).map(move |k| from_s + f64::from(k) * 1e-3)
}

#[test]
fn a_gap_that_would_be_filled_with_endless_samples_is_refused() {
    let folder = TestFolder::new();
    let gap = |after_s: f64| recording(milliseconds(0.0, 200).chain(milliseconds(after_s, 200)));
    folder.file("endless.csv", gap(1e11)).file("long.csv", gap(6000.0)).file("short.csv", gap(3.0));
    let phrases = ["at most 5000000", "recording.max_samples", "longest gap", "cut the recording"];
    for command in ["detect", "calibrate", "roc"] {
        folder.refused(&[command, "endless.csv", "--set", "recording.max_gap_s=1e12"], &phrases);
    }
    folder.refused(&["detect", "long.csv", "--set", "recording.max_gap_s=1e12"], &phrases);
    let boundless = ["--set", "recording.max_gap_s=1e12", "--set", "recording.max_samples=9000000000000000000"];
    folder.refused(&[&["detect", "endless.csv"], &boundless[..]].concat(), &["at most 1000000000"]);
    folder.file("s.toml", "recording.file = \"endless.csv\"\nrecording.max_gap_s = 1e12\n");
    folder.refused(&["detect", "s.toml"], &["s.toml:2:", "longest gap"]);
    let printed = folder.good(&["detect", "short.csv", "--no-figures", "--set", "recording.max_gap_s=1e12"]);
    assert!(printed.starts_with("short: 3200 samples"), "{printed}");
}

#[test]
fn a_settings_file_without_settings_is_refused() {
    let folder = TestFolder::new();
    folder.file("r.csv", recording(milliseconds(0.0, 200)));
    folder.file("none.toml", SHORT).file("half.toml", "detector.threshold = 0.05\n");
    folder.refused(&["detect", "r.csv", "--settings", "none.toml"], &["none.toml", "[estimator]", "[detector]"]);
    assert_eq!(folder.warned(&["detect", "r.csv", "--no-figures", "--settings", "half.toml"]), "");
}

#[test]
fn samples_too_far_apart_for_a_rupture_give_a_warning() {
    let folder = TestFolder::new();
    let every = |interval_s: f64| recording((0..600).map(|k| f64::from(k) * interval_s));
    folder.file("a/slow.csv", every(1.0)).file("a/fast.csv", every(0.01));
    let warned = |arguments: &[&str]| folder.warned(&[&["detect", "--no-figures"], arguments].concat());
    for given in ["a/slow.csv", "a"] {
        let said = warned(&[given]);
        let expected = "warning[low-sampling-rate]: a/slow.csv: the sampling rate is 1.000 Hz, below 100";
        assert!(said.starts_with(expected), "{said}");
        assert_eq!(said.matches("warning[").count(), 1, "{said}");
    }
    assert_eq!((warned(&["a/fast.csv"]), warned(&["a", "--quiet"])), (String::new(), String::new()));
    let live = folder.fed(&["detect", "-"], every(1.0).as_bytes()).err;
    assert!(live.contains("warning[low-sampling-rate]: standard input: the sampling rate is 1.000 Hz"), "{live}");
    let live = folder.fed(&["detect", "-"], every(0.01).as_bytes()).err;
    assert!(!live.contains("the sampling rate is"), "{live}");
}

#[test]
fn a_calibration_refuses_times_out_of_range_with_the_limit() {
    let folder = TestFolder::new();
    for (flag, text, phrases) in [
        ("--false-alarm-s", "1e30", &["--false-alarm-s is 1e30", "to 1.000e7 s", "1e10 samples"][..]),
        ("--false-alarm-s", "1.1e7", &["--false-alarm-s is 11000000.0", "to 1.000e7 s"]),
        ("--false-alarm-s", "1e-3", &["--false-alarm-s is 0.001", "from 2.000e-3"]),
        ("--quiet-s", "4,1", &["4,1", "4 s is not before 1 s"]),
        ("--quiet-s", "4", &["4", "two times"]),
    ] {
        folder.refused(&["calibrate", "builtin:in_vivo_like.csv", flag, text], phrases);
    }
    folder.good(&["calibrate", "builtin:in_vivo_like.csv", "--false-alarm-s", "9.9e6", "--quiet"]);
}

#[test]
fn an_output_that_cannot_be_written_is_a_failure() {
    let folder = TestFolder::new();
    folder.file("a.toml", SHORT).file("taken", "a file");
    let outcome = folder.trocar(&["run", "a.toml", "--out", "taken"]);
    assert_eq!(outcome.code, 1, "{}", outcome.err);
    assert!(outcome.err.contains("taken") && outcome.err.contains("another folder"), "{}", outcome.err);
}

#[test]
fn a_run_that_diverges_is_a_result() {
    let folder = TestFolder::new();
    let set = ["--set", "master.coupling=as-printed"];
    let printed = folder.said(&[&["run", "paper/classical"], &set[..]].concat());
    assert!(printed.starts_with("classical: The loop is not stable"), "{printed}");
    assert!(printed.contains("classical: diverged at 0."), "{printed}");
    let printed = folder.said(&[&["compare"], &set[..]].concat());
    assert!(printed.contains("diverged at"), "{printed}");
}

#[test]
fn a_starter_is_written_once_and_runs() {
    let folder = TestFolder::new();
    folder.good(&["init", "mine.toml"]);
    assert!(folder.good(&["check", "mine.toml"]).starts_with("mine: valid"));
    folder.refused(&["init", "mine.toml"], &["already exists", "--force"]);
    for kind in ["--layers", "--replay", "--minimal", "--all"] {
        folder.good(&["init", "mine.toml", "--force", kind]);
        assert!(folder.good(&["check", "mine.toml"]).starts_with("mine: valid"), "{kind}");
    }
    assert_eq!(folder.trocar(&["init", "other.toml", "--layers", "--replay"]).code, 2);
    folder.good(&["record", "--seed", "7", "--out", "seven.csv"]);
    folder.refused(&["record", "--out", "seven.csv"], &["already exists"]);
    assert_eq!(folder.good(&["record", "--seed", "7", "--out", "-"]), folder.text("seven.csv"));
    let ruptures = ["--rupture-s", "5.52", "--rupture-s", "8.85"];
    let said = folder.said(&[&["detect", "seven.csv", "--velocity", "velocity_m_per_s"][..], &ruptures].concat());
    assert!(said.contains("0 of 2 labelled ruptures missed, 0 false alarms."), "{said}");
}

#[test]
fn a_shipped_scenario_has_short_names() {
    let folder = TestFolder::new();
    let text = folder.good(&["scenarios", "show", "layers/epidural"]);
    assert_eq!(text, fs::read_to_string(file("scenarios/layers/epidural.toml")).expect("there"));
    let resolved = |name: &str| folder.trocar(&["check", "--resolved", name]);
    let present = resolved("layers/skin-augmented");
    for name in ["skin-augmented", "builtin:layers/skin-augmented.toml"] {
        let outcome = resolved(name);
        assert_eq!((&outcome.out, outcome.err.as_str()), (&present.out, ""), "{name}");
    }
    // A file has priority, and a base falls back to shipped scenarios.
    folder.file("mine.toml", "name = \"mine\"\nbase = \"paper/augmented\"\n");
    assert!(folder.good(&["check", "mine.toml"]).starts_with("mine: valid, 17000 ticks"));
    folder.file(
        "paper/augmented",
        "simulation.duration_s = 2.0\noperator.kind = \"ramp\"\ntissue.kind = \"kelvin-voigt\"\n",
    );
    assert!(folder.good(&["check", "mine.toml"]).starts_with("mine: valid, 2000 ticks"));
    folder.refused(&["check", "layers/skin-augmentd"], &["did you mean layers/skin-augmented?", "`trocar scenarios`"]);
    folder.refused(&["check", "classical.toml"], &["cannot be read", "did you mean paper/classical?"]);
}

#[test]
fn limits_of_motors_need_sampled_control() {
    let folder = TestFolder::new();
    for (key, reason) in [
        ("master_force_limit_n", "saturates"),
        ("master_force_rate_limit_n_per_s", "saturates"),
        ("slave_command_rate_limit_per_s", "saturates"),
        ("master_lag_s", "held"),
        ("slave_lag_s", "held"),
    ] {
        folder.file("d.toml", format!("{SHORT}actuator.{key} = 0.5\n"));
        let needs = format!("actuator.{key} needs");
        folder.refused(&["run", "d.toml"], &["d.toml:5", &needs, "control = \"sampled\"", reason]);
        folder.good(&["check", "d.toml", "--set", "simulation.control=sampled"]);
    }
}

#[test]
#[ignore = "more than 5 s of processor time"]
fn a_study_over_seeds_is_the_same_on_any_number_of_threads() {
    let folder = TestFolder::new();
    let noisy = ["compare", "--seeds", "5", "--set", "sensor.force_noise_std_n=0.02", "--out"];
    let run = |threads: &str| {
        let mut command = folder.command(&noisy);
        let output = command.arg(threads).env("RAYON_NUM_THREADS", threads).output().expect("ran");
        String::from_utf8(output.stdout).expect("text")
    };
    let printed = ["1", "4"].map(run);
    assert!(folder.files("1") == folder.files("4"));
    assert!(printed[0].contains("over 5 seeds"), "{}", printed[0]);
    let study = folder.text("1/compare/seeds.csv");
    assert!(study.contains("rupture_1_slave_overshoot_m,m,augmented,5,"), "{study}");
    let silent = folder.good(&["compare", "--seeds", "3"]);
    assert!(silent.contains("No metric depends on the seed"), "{silent}");
    folder.refused(&["compare", "--seeds", "1"], &["--seeds", "2..=100000"]);
}

#[test]
fn scenarios_that_cannot_be_realised_are_refused_with_the_reason() {
    let folder = TestFolder::new();
    let skin = "builtin:layers/through-the-skin.toml";
    for (setting, phrases) in [
        (
            "perception.reflex_reaction_max_s=0.1",
            ["perception.reflex_reaction_max_s", "perception.reflex_reaction_min_s"],
        ),
        ("perception.reflex_weber_fraction=1.0", ["perception.reflex_weber_fraction", "between 0 and 1"]),
        ("operator.tremor_high_hz=7", ["operator.tremor_high_hz", "operator.tremor_low_hz"]),
        ("arm.grip=limp", ["arm.grip", "relaxed"]),
    ] {
        folder.refused(&["run", skin, "--set", "perception.reflex=stop", "--set", setting], &phrases);
    }
}

#[test]
fn roc_writes_every_point_and_refuses_what_it_cannot_evaluate() {
    let folder = TestFolder::new();
    let few = ["roc", "--seeds", "2", "--thresholds", "4", "--detectors", "squared-residual,page-hinkley", "--json"];
    let json = folder.json(&few);
    assert_eq!(json["characteristics"]["cases"], 2);
    // Without a false alarm in half a minute, the rate is undefined and not 0.
    assert!(json["characteristics"]["all"][0]["points"][2]["false_alarms_per_minute"].is_null());
    let left = folder.files("out/roc");
    let names: Vec<_> = left.keys().map(|path| path.display().to_string()).collect();
    assert_eq!(names, ["manifest.json", "roc.csv", "roc.json", "roc.png", "roc.svg"]);
    let csv = String::from_utf8(left[Path::new("roc.csv")].clone()).expect("text");
    // A heading, and four thresholds for each of the two detectors: for all conditions together and for the single
    // condition.
    assert_eq!(csv.lines().count(), 1 + 2 * 2 * 4);
    let columns = csv.lines().next().expect("a heading").split(',').count();
    assert!(csv.lines().all(|line| line.split(',').count() == columns), "{csv}");
    let text = folder.good(&few[..few.len() - 1]);
    assert!(
        text.starts_with("2 runs: 4 ruptures and 0.5 min without a rupture. An alarm within 10 ms counts"),
        "{text}"
    );
    assert!(text.contains("not resolvable") && text.contains("its own"), "{text}");
    folder.refused(&["roc", "--drop-n", "-1"], &["0.01"]);
    folder.refused(&["roc", "--detectors", "squared"], &["squared-residual"]);
    folder.refused(&["roc", "--drop-n", "1", "builtin:paper/real-classical.toml"], &["synthetic insertion"]);
    folder.refused(&["roc", "nowhere.csv"], &["nowhere.csv"]);
    let step = ["roc", "builtin:layers/through-the-skin.toml", "--set", "sensor.position_resolution_m=1e-5"];
    folder.refused(&step, &["position_resolution_m=0"]);
    let window = ["roc", "--seeds", "1", "--set", "detector.window_samples=65"];
    folder.refused(&window, &["detector.window_samples is 65", "64"]);
}

#[cfg(unix)]
#[test]
fn an_interrupted_roc_reports_what_it_kept() {
    let folder = TestFolder::new();
    let child = folder.begin(&["roc", "--seeds", "1000000", "--thresholds", "2", "--detectors", "squared-residual"]);
    // Wait until the handler is installed and the work has started.
    std::thread::sleep(std::time::Duration::from_secs(3));
    let kill = std::process::Command::new("kill").args(["-INT", &child.id().to_string()]).status().expect("sent");
    assert!(kill.success());
    let output = child.wait_with_output().expect("ended");
    let said = String::from_utf8(output.stderr).expect("text");
    assert_eq!(output.status.code(), Some(130), "{said}");
    if said.contains("nothing was written") {
        assert!(folder.files("").is_empty());
    } else {
        assert!(said.contains("of 1000000 cases are in out"), "{said}");
        assert!(String::from_utf8(output.stdout).expect("text").starts_with("stopped after"));
        assert_eq!(folder.files("out").len(), 5);
    }
}

#[test]
fn completions_know_the_commands_the_shipped_scenarios_and_the_keys() {
    let folder = TestFolder::new();
    let commands = folder.commands();
    let [bash, zsh, fish, elvish, powershell] =
        ["bash", "zsh", "fish", "elvish", "powershell"].map(|shell| folder.good(&["completions", shell]));
    for script in [&bash, &zsh, &fish, &elvish, &powershell] {
        assert!(commands.iter().all(|command| script.contains(command)), "{script}");
    }
    for script in [&bash, &zsh, &fish] {
        for word in ["paper/classical", "layers/skin-augmented", "detector.threshold="] {
            assert!(script.contains(word), "{word}: {script}");
        }
    }
    for command in ["run", "link", "scenarios"] {
        let start = format!("complete -c trocar -n \"__fish_trocar_using_subcommand {command}\" -a \"");
        assert!(fish.lines().any(|line| line.starts_with(&start) && line.contains("paper/classical ")), "{command}");
    }
    assert!(zsh.contains("'*--set=[") && zsh.contains(":SECTION.KEY=VALUE:_trocar_settings'"), "{zsh}");
    assert!(zsh.contains(":_trocar_scenarios'") && zsh.starts_with("#compdef trocar"), "{zsh}");
}

/// The script returns no files of the user; bash completes them itself.
#[test]
fn bash_completes_scenarios_and_keys() {
    let folder = TestFolder::new();
    fs::write(folder.path("completions.bash"), folder.good(&["completions", "bash"])).expect("write");
    for (words, expected) in [
        ("trocar run paper/classical", "paper/classical"),
        ("trocar compare my.toml paper/classical", "paper/classical"),
        ("trocar scenarios show layers/skin-aug", "layers/skin-augmented"),
        ("trocar run my.toml --set detector.thres", "detector.threshold="),
        ("trocar run my", ""),
    ] {
        let line = format!(
            "source completions.bash && COMP_WORDS=({words}) && COMP_CWORD=$((${{#COMP_WORDS[@]}} - 1)) && \
             _trocar trocar \"${{COMP_WORDS[COMP_CWORD]}}\" \"${{COMP_WORDS[COMP_CWORD-1]}}\" 2> errors; echo \"${{COMPREPLY[*]}}\""
        );
        let output = std::process::Command::new("bash").args(["-c", &line]).current_dir(folder.path(".")).output();
        let Ok(output) = output else {
            eprintln!("skipped: there is no bash");
            return;
        };
        assert_eq!(String::from_utf8_lossy(&output.stdout).trim(), expected, "{words}");
    }
}

#[test]
fn output_without_a_terminal_has_no_chart_and_no_colour() {
    let folder = TestFolder::new();
    let printed = folder.good(&["run", "builtin:paper/augmented.toml"]);
    assert!(!printed.contains('\u{1b}') && !printed.contains("slave position around"), "{printed}");
    // `script` provides a terminal.
    let trocar = env!("CARGO_BIN_EXE_trocar");
    let on_terminal = |colours: &[(&str, &str)]| {
        let line = format!("{trocar} run builtin:paper/augmented.toml --out on-terminal");
        let mut command = std::process::Command::new("script");
        command.args(["--quiet", "--return", "--command", &line, "/dev/null"]).current_dir(folder.path("."));
        command.env("TERM", "xterm-256color").env_remove("NO_COLOR").envs(colours.iter().copied());
        command.output().ok().map(|output| String::from_utf8_lossy(&output.stdout).into_owned())
    };
    let Some(plain) = on_terminal(&[("NO_COLOR", "1")]) else {
        eprintln!("left out: there is no `script` to make a terminal");
        return;
    };
    assert!(plain.contains("slave position around rupture 1"), "{plain}");
    assert!(!plain.contains("\u{1b}[3"), "{plain}");
    let coloured = on_terminal(&[]).expect("there is one");
    assert!(coloured.contains("\u{1b}[3"), "{coloured}");
}
