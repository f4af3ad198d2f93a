//! `trocar detect` on many recordings: order, files, labels and errors.

use crate::support::test_folder::TestFolder;
use serde_json::Value as Json;

/// A tick of the small recordings below, in s.
const TICK_S: f64 = 1e-3;

/// Returns a needle that moves at 10 mm/s for `duration_s` through a tissue of 300 N/m that ruptures at `ruptures_s`.
fn insertion(start_s: f64, duration_s: f64, ruptures_s: &[f64]) -> String {
    let mut text = String::from("time_s,position_m,velocity_m_per_s,force_n\n");
    for k in 0..=(duration_s / TICK_S).round() as u32 {
        let t = f64::from(k) * TICK_S;
        let since = ruptures_s.iter().filter(|&&rupture| t > rupture).fold(0.0_f64, |last, &rupture| last.max(rupture));
        let position = 1e-2 * t;
        // After a rupture the force starts again from nearly 0 at the next layer.
        let force = 300.0 * 1e-2 * (t - 0.95 * since);
        text.push_str(&format!("{:.3},{position:.6},0.01,{force:.4}\n", start_s + t));
    }
    text
}

const VELOCITY: [&str; 2] = ["--velocity", "velocity_m_per_s"];

/// Returns a folder with three recordings: with ruptures at 1 s and 2 s; with a rupture at 1.5 s and a clock that
/// starts at 10 s; and without ruptures.
fn three_recordings() -> TestFolder {
    let folder = TestFolder::new();
    folder
        .file("a/two.csv", insertion(0.0, 3.0, &[1.0, 2.0]))
        .file("a/one.csv", insertion(10.0, 3.0, &[1.5]))
        .file("b/none.csv", insertion(0.0, 3.0, &[]));
    folder
}

fn detect<'a>(arguments: &[&'a str]) -> Vec<&'a str> {
    [&["detect"], arguments, &VELOCITY[..], &["--no-figures"]].concat()
}

fn json(text: &str) -> Json {
    serde_json::from_str(text).expect("JSON")
}

#[test]
fn a_folder_stands_for_its_recordings_and_a_bad_recording_does_not_stop_the_others() {
    let folder = three_recordings();
    folder.file("a/bad.csv", "time_s,position_m,velocity_m_per_s,force_n\n0,0,0,0\n0.001,soft,0,0\n");
    folder.file("a/notes.txt", "no recording");
    let outcome = folder.trocar(&detect(&["a", "missing.csv", "b/none.csv"]));
    assert_eq!(outcome.code, 2, "{}", outcome.err);
    assert!(outcome.err.contains("a/bad.csv line 3, column 'position_m': 'soft' is not a number"), "{}", outcome.err);
    assert!(outcome.err.contains("missing.csv"), "{}", outcome.err);
    assert!(outcome.err.contains("2 of 5 recordings failed"), "{}", outcome.err);
    let order: Vec<&str> =
        outcome.out.lines().skip_while(|line| !line.contains("samples")).filter_map(|l| l.split(' ').next()).collect();
    assert_eq!(order[2..8], ["bad", "one", "two", "missing", "none", "all"], "{}", outcome.out);
    for name in ["one", "two", "none"] {
        assert!(folder.path(&format!("out/detect/{name}/detection.csv")).exists(), "{name}");
    }
    assert!(!folder.path("out/detect/bad").exists() && !folder.path("out/detect/missing").exists());
    assert!(folder.files("out").keys().all(|path| path.extension().is_none_or(|end| end != "png")), "--no-figures");
    let all = json(&folder.text("out/detect/detections.json"));
    let recordings = all["recordings"].as_array().expect("a list");
    assert_eq!(recordings.len(), 5);
    assert!(recordings[0]["error"].as_str().is_some_and(|error| error.contains("soft")), "{}", recordings[0]);
    assert_eq!(recordings[2]["alarms"].as_array().map(Vec::len), Some(2));
    assert!(all["scores"].is_null(), "nothing is labelled");
    folder.file("empty/readme.txt", "").refused(&["detect", "empty"], &["empty", "no *.csv file"]);
    // A folder counts as many recordings even with one.
    let one = folder.json(&detect(&["b", "--json"]));
    assert_eq!(
        (one["recordings"].as_array().map(Vec::len), &one["recordings"][0]["folder"]),
        (Some(1), &"none".into())
    );
}

#[test]
fn the_results_are_the_same_for_any_number_of_threads() {
    let folder = three_recordings();
    // A recording that is given twice has no unique name, but needs no labels.
    folder.file("l.csv", "file,time_s\na/one.csv,11.5\nb/none.csv,\n");
    let mut printed = vec![];
    for threads in ["1", "8"] {
        let mut command = folder.command(&["detect", "a", "b", "a/two.csv", "--labels", "l.csv", "--out", threads]);
        let output = command.args(VELOCITY).env("RAYON_NUM_THREADS", threads).output().expect("ran");
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        printed.push(String::from_utf8(output.stdout).expect("text").replace(&format!("files: {threads}/detect"), ""));
    }
    assert_eq!(printed[0], printed[1]);
    let files = folder.files("1/detect");
    assert!(files == folder.files("8/detect"));
    for name in ["timeline.svg", "timeline.png", "delays.svg", "events.csv", "detections.json", "two-2/decision.png"] {
        assert!(files.contains_key(std::path::Path::new(name)), "{name} in {:?}", files.keys());
    }
}

#[test]
fn many_recordings_give_one_json_document_and_a_single_one_the_same_object() {
    let folder = three_recordings();
    let printed = folder.good(&detect(&["a", "b", "--json"]));
    assert_eq!(printed, folder.text("out/detect/detections.json"));
    let all = json(&printed);
    let two = &all["recordings"][1];
    assert_eq!((two["file"].as_str(), two["folder"].as_str()), (Some("a/two.csv"), Some("two")));
    let alone = folder.json(&detect(&["a/two.csv", "--json", "--out", "alone"]));
    for key in ["alarms", "phases", "residual", "samples", "settings"] {
        assert_eq!(two[key], alone[key], "{key}");
    }
    assert!(alone["alarms"][0]["time_s"].is_number() && alone["scores"].is_null() && alone["false_alarms"].is_null());
    assert_eq!(folder.text("out/detect/two/events.csv"), folder.text("alone/two/events.csv"));
    let joint = folder.text("out/detect/events.csv");
    let rows: Vec<&str> = joint.lines().collect();
    assert!(rows[0].starts_with("file,event,time_s,sample,position_m"), "{joint}");
    assert!(rows[1].starts_with("a/one.csv,alarm,11.50") && rows[2].starts_with("a/two.csv,alarm,1.00"), "{joint}");
}

#[test]
fn recordings_with_the_same_name_have_separate_folders() {
    let folder = three_recordings();
    folder.file("c/two.csv", insertion(0.0, 3.0, &[1.2]));
    folder.file("s.toml", "name = \"two\"\nrecording.file = \"a/two.csv\"\nrecording.ruptures_s = [1.0, 2.0]\n");
    let printed = folder.good(&detect(&["a/two.csv", "c/two.csv", "s.toml", "a/two.csv"]));
    for name in ["two ", "two-2", "two-3", "two-4"] {
        assert!(printed.lines().any(|line| line.starts_with(name)), "{name} in\n{printed}");
    }
    let time = |name: &str| json(&folder.text(name))["alarms"][0]["time_s"].as_f64().expect("a time");
    assert!((1.0..1.02).contains(&time("out/detect/two/detection.json")));
    assert!((1.2..1.22).contains(&time("out/detect/two-2/detection.json")));
    let scenario = json(&folder.text("out/detect/two-3/detection/detection.json"));
    assert_eq!((&scenario["missed_ruptures"], &scenario["scores"]["recall"]), (&Json::from(0), &Json::from(1.0)));
}

#[test]
fn labels_are_matched_with_alarms_one_to_one() {
    let folder = three_recordings();
    // Two ruptures and a false label; one rupture; none; in any order.
    folder.file(
        "l.csv",
        "# seen on video\nfile;time_s;kind\na/two.csv;2.0;muscle\none.csv;11.5;skin\ntwo.csv;0.4;skin\nnone.csv;;\n\
         two.csv;1;skin\n",
    );
    let printed = folder.good(&detect(&["a", "b/none.csv", "--labels", "l.csv"]));
    let total = printed.lines().find(|line| line.starts_with("all 3 labelled")).expect("a total");
    let cells: Vec<&str> = total["all 3 labelled".len()..].split_whitespace().collect();
    assert_eq!(cells[..4], ["4", "3", "1", "0"], "ruptures, found, missed, false: {printed}");
    assert_eq!(cells[4..10], ["100.0", "%", "75.00", "%", "85.71", "%"], "{printed}");
    let all = json(&folder.text("out/detect/detections.json"));
    let (one, two, none) = (&all["recordings"][0], &all["recordings"][1], &all["recordings"][2]);
    assert_eq!((&one["scores"]["found"], &two["scores"]["missed"]), (&Json::from(1), &Json::from(1)));
    assert_eq!(two["labelled_ruptures_s"], serde_json::json!([0.4, 1.0, 2.0]));
    assert_eq!(two["labelled_kinds"], serde_json::json!(["skin", "skin", "muscle"]));
    for undefined in ["precision", "recall", "f1", "median_delay_s"] {
        assert!(none["scores"][undefined].is_null(), "{undefined} of no alarm and no rupture: {none}");
    }
    assert_eq!(none["scores"]["false_alarms_per_minute"], 0.0);
    let events = folder.text("out/detect/two/events.csv");
    let kinds: Vec<(&str, &str)> = events
        .lines()
        .skip(1)
        .map(|line| line.split(',').collect::<Vec<_>>())
        .map(|cells| (cells[1], cells[9]))
        .collect();
    assert_eq!(kinds, [("missed", "skin"), ("found", "skin"), ("found", "muscle")], "{events}");

    // With a window shorter than every delay, every alarm is false and every rupture is missed.
    folder.file("l2.csv", "file,time_s\ntwo.csv,0.9\none.csv,11.4\n");
    let strict = folder.json(&detect(&["a", "--labels", "l2.csv", "--within-s", "0", "--json"]));
    assert_eq!((&strict["scores"]["false_alarms"], &strict["scores"]["missed"]), (&Json::from(3), &Json::from(2)));
    let per_minute = strict["scores"]["false_alarms_per_minute"].as_f64().expect("defined");
    assert!((per_minute - 3.0 / (6.0 / 60.0)).abs() < 1e-6, "3 in 6 s: {per_minute}");
    // An alarm before its rupture is false, however near.
    folder.file("l2.csv", "file,time_s\ntwo.csv,1.1\n");
    let early = folder.json(&detect(&["a/two.csv", "--labels", "l2.csv", "--json"]));
    assert_eq!((&early["missed_ruptures"], &early["false_alarms"]), (&Json::from(1), &Json::from(2)));
}

#[test]
fn labels_in_the_folder_of_a_recording_are_read_by_default() {
    let folder = three_recordings();
    folder.file("a/two.labels.csv", "time_s,kind\n1.0,skin\n").file("b/none.labels.csv", "time_s\n");
    let all = folder.json(&detect(&["a", "b", "--json"]));
    let of = |index: usize| &all["recordings"][index];
    assert_eq!(all["recordings"].as_array().map(Vec::len), Some(3), "the labels are no recording");
    assert!(of(0)["scores"].is_null(), "not labelled, so not judged");
    assert_eq!((&of(1)["scores"]["found"], &of(1)["false_alarms"]), (&Json::from(1), &Json::from(1)));
    assert_eq!((&of(2)["scores"]["ruptures"], &of(2)["false_alarms"]), (&Json::from(0), &Json::from(0)));
    assert_eq!(all["scores"]["recordings"], 2);
    let explicit = folder.json(&detect(&["a/two.csv", "--rupture-s", "1", "--rupture-s", "2", "--json"]));
    assert_eq!((&explicit["missed_ruptures"], &explicit["false_alarms"]), (&Json::from(0), &Json::from(0)));
    folder.file("b/none.labels.csv", "time_s\nsoon\n");
    let outcome = folder.trocar(&detect(&["a", "b"]));
    assert_eq!(outcome.code, 2);
    assert!(
        outcome.err.contains("b/none.labels.csv line 2, column 'time_s': 'soon' is not a number"),
        "{}",
        outcome.err
    );
}

#[test]
fn bad_labels_are_refused_with_file_and_line() {
    let folder = three_recordings();
    let cases: [(&str, &[&str]); 11] = [
        ("file,time_s\ntwo.csv,1\nthree.csv,1\n", &["l.csv line 3", "'three.csv' is not one of the given recordings"]),
        ("file,time_s\ntwo.csv,NaN\n", &["l.csv line 2", "'NaN' is not finite"]),
        ("file,time_s\ntwo.csv,inf\n", &["l.csv line 2", "not finite"]),
        ("file,time_s\ntwo.csv,first\n", &["l.csv line 2", "'first' is not a number"]),
        ("file,time_s\n,1\n", &["l.csv line 2", "column 'file'", "empty"]),
        ("file,time_s\ntwo.csv\n", &["l.csv line 2", "1 fields, the header 2"]),
        ("file,when\ntwo.csv,1\n", &["l.csv", "no column 'time_s'"]),
        ("time_s\n1\n", &["l.csv", "no column 'file'"]),
        ("two.csv,1\n", &["l.csv", "no column 'file'"]),
        ("", &["l.csv", "holds no data"]),
        ("file,time_s\ntwo.csv,\0\n", &["l.csv line 2", "binary"]),
    ];
    for (content, phrases) in cases {
        folder.file("l.csv", content);
        folder.refused(&detect(&["a", "b", "--labels", "l.csv"]), phrases);
    }
    folder.refused(&detect(&["a", "--labels", "gone.csv"]), &["gone.csv", "cannot be read"]);
    folder.file("l.csv", "file,time_s\ntwo.csv,1\n");
    folder.refused(&detect(&["a/two.csv", "./a/two.csv", "--labels", "l.csv"]), &["matches a/two.csv and ./a/two.csv"]);
    // Errors that depend on the recording.
    for (content, phrases) in [
        ("time_s\n-0.1\n", ["l.csv line 2", "-0.1 s is outside the recording, which lasts from 0 to 3 s"]),
        ("time_s\n1\n3.1\n", ["l.csv line 3", "outside the recording"]),
        ("time_s\n2\n1\n2.0\n", ["l.csv line 4", "already on line 2"]),
        ("kind,time_s\nskin,2\n,\nnone,\n", ["l.csv line 4", "line 2 labels one"]),
    ] {
        folder.file("l.csv", content);
        folder.refused(&detect(&["a/two.csv", "--labels", "l.csv"]), &phrases);
    }
}

#[test]
fn flags_that_exclude_each_other_are_refused() {
    let folder = three_recordings();
    folder.file("l.csv", "file,time_s\n");
    folder.refused(&detect(&["a", "--rupture-s", "1"]), &["--rupture-s labels a single recording", "--labels"]);
    folder.refused(&detect(&["a/two.csv", "--rupture-s", "1", "--labels", "l.csv"]), &["--labels"]);
    folder.refused(&detect(&["a/two.csv", "--every", "3"]), &["--every is for a live stream"]);
    folder.refused(&detect(&["a/two.csv", "--interval-s", "0.001"]), &["--interval-s is for a live stream"]);
    folder.refused(&detect(&["a/two.csv", "-"]), &["cannot be combined with recordings"]);
    folder.refused(&detect(&["-", "--labels", "l.csv"]), &["--labels is for recordings"]);
    for bad in ["-0.1", "nan", "inf"] {
        folder.refused(&detect(&["a/two.csv", "--within-s", bad]), &["--within-s", "at least 0"]);
    }
    folder.refused(&["detect"], &["<RECORDING>"]);
    let bad = folder.trocar(&detect(&["a", "b", "--set", "detector.capp=1"]));
    assert_eq!((bad.code, bad.err.matches("did you mean").count()), (2, 1), "once for all: {}", bad.err);
}

#[test]
fn the_phases_of_the_shipped_insertion_are_found() {
    let folder = TestFolder::new();
    let found = folder.json(&["detect", "builtin:in_vivo_like.csv", "--no-figures", "--json"]);
    let phases = found["phases"].as_array().expect("a list");
    let durations: Vec<f64> = phases.iter().map(|phase| phase["duration_s"].as_f64().expect("defined")).collect();
    let names: Vec<_> = phases.iter().filter_map(|phase| phase["phase"].as_str()).collect();
    assert_eq!(names, ["free", "insertion", "hold", "withdrawal"]);
    assert!((durations.iter().sum::<f64>() - 17.0).abs() < 1e-9, "each sample in one phase: {durations:?}");
    // The needle rests at 48 mm from 12.2 s to 14.2 s and then moves out, through the surface at 16.25 s.
    assert!((1.9..2.3).contains(&durations[2]) && (2.0..2.3).contains(&durations[3]), "{durations:?}");
    assert!(phases[0]["mean_stiffness_n_per_m"].is_null() && phases[1]["mean_stiffness_n_per_m"].is_number());
    let printed = folder.good(&["detect", "builtin:in_vivo_like.csv", "--no-figures"]);
    assert!(printed.contains("phase       duration ") && printed.contains("B ± 2 s.e."), "{printed}");
}

#[test]
fn degenerate_recordings_give_no_alarm_and_only_finite_numbers() {
    let folder = TestFolder::new();
    let table = |row: &dyn Fn(f64) -> [f64; 2], samples: u32| {
        let mut text = String::from("time_s,position_m,velocity_m_per_s,force_n\n");
        for k in 0..samples {
            let t = f64::from(k) * TICK_S;
            let [position, force] = row(t);
            text.push_str(&format!("{t:.3},{position},0,{force}\n"));
        }
        text
    };
    folder
        .file("d/zeros.csv", table(&|_| [0.0, 0.0], 2000))
        .file("d/constant.csv", table(&|_| [0.02, 5.0], 2000))
        .file("d/motionless.csv", table(&|t| [0.02, if t < 1.0 { 5.0 } else { 4.99 }], 2000))
        .file("d/no_contact.csv", table(&|t| [-0.02, (9.0 * t).sin()], 2000))
        .file("d/two_samples.csv", table(&|t| [0.01 + t, 1.0], 2));
    for velocity in [&VELOCITY[..], &[]] {
        let arguments = [&["detect", "d", "--json"], velocity].concat();
        let all = folder.json(&arguments);
        for recording in all["recordings"].as_array().expect("a list") {
            assert_eq!(recording["alarms"], serde_json::json!([]), "{recording}");
            let residual = recording["residual"].as_object().expect("statistics");
            assert!(residual.values().all(Json::is_number), "{recording}");
            let samples =
                folder.text(&format!("out/detect/{}/detection.csv", recording["folder"].as_str().expect("a name")));
            let numbers = samples.lines().skip(1).flat_map(|line| line.split(',').map(str::parse::<f64>));
            assert!(numbers.into_iter().all(|number| number.is_ok_and(f64::is_finite)));
        }
    }
    folder.file("d/one_sample.csv", table(&|_| [0.0, 0.0], 1));
    folder.refused(&["detect", "d/one_sample.csv"], &["a single sample"]);
}
