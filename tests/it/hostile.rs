//! Damaged files and files that are made to cost time or memory, through the commands. The limits of each format are
//! tested beside the readers.

use std::time::{Duration, Instant};

use crate::support::file;
use crate::support::test_folder::{Outcome, TestFolder};

/// Longest time of an answer, and its largest size in bytes.
const LONGEST: Duration = Duration::from_secs(10);
const MAX_OUTPUT: usize = 100_000;

fn answer(folder: &TestFolder, arguments: &[&str]) -> Outcome {
    let start = Instant::now();
    let outcome = folder.trocar(arguments);
    assert!(start.elapsed() < LONGEST, "{arguments:?}: {:?}", start.elapsed());
    assert!(outcome.out.len() + outcome.err.len() < MAX_OUTPUT, "{arguments:?}");
    outcome
}

fn refusal(folder: &TestFolder, arguments: &[&str]) -> String {
    let outcome = answer(folder, arguments);
    assert_eq!(outcome.code, 2, "{arguments:?}: {}", outcome.err);
    outcome.err
}

#[test]
fn damaged_recordings_are_errors_with_file_and_place() {
    let folder = TestFolder::new();
    let cases = [
        ("flip24_a.mcap", "CRC failed"),
        ("tdms_300_of_400.tdms", "does not end where its raw data begins"),
        ("force_1e9.csv", "force_1e9.csv line 4, column 'force_n': is 1e9 N, at most 1e6 N"),
    ];
    for (name, phrase) in cases {
        let path = file(&format!("tests/data/hostile/{name}"));
        let error = refusal(&folder, &["detect", path.to_str().expect("a path")]);
        assert!(error.contains(name) && error.contains(phrase), "{error}");
    }
}

#[test]
fn a_recording_that_may_be_cut_off_has_a_warning() {
    let folder = TestFolder::new();
    let text = std::fs::read_to_string(file("tests/data/hostile/cut_b.csv")).expect("a file");
    folder.file("cut.csv", &text).file("whole.csv", format!("{text}\n"));
    let of = |name: &str| answer(&folder, &["detect", name, "--no-figures"]);
    let cut = of("cut.csv");
    assert!(cut.code == 0 && cut.err.contains("warning[unfinished-file]"), "{}", cut.err);
    assert!(cut.err.replace("\n ", "").contains("last line, 5,"), "{}", cut.err);
    assert!(!of("whole.csv").err.contains("unfinished-file"));
}

#[test]
fn a_wide_table_is_listed_briefly() {
    let folder = TestFolder::new();
    let names: Vec<String> = (0..1000).map(|k| format!("c{k}")).collect();
    let row = vec!["1"; 1000].join(",");
    folder.file("wide.csv", format!("{}\n{row}\n{row}\n", names.join(",")));
    let listed = folder.good(&["detect", "wide.csv", "--list"]);
    assert!(listed.contains("800 signals more"), "{listed}");
}

#[test]
fn long_and_many_keys_have_short_messages() {
    let folder = TestFolder::new();
    let start = "name = \"a\"\nbase = \"paper/classical\"\n";
    let long = "k".repeat(50_000);
    folder
        .file("key.toml", format!("{start}{long} = 1\n"))
        .file("keys.toml", start.to_owned() + &(0..20_000).map(|k| format!("k{k} = 1\n")).collect::<String>())
        .file("base.toml", format!("name = \"a\"\nbase = \"{long}\"\n"))
        .file("value.toml", format!("{start}operator.kind = \"{long}\"\n"))
        .file("sweep.toml", format!("base = \"paper/classical\"\nmetrics = [\"{long}\"]\n[axes]\n{long} = [1, 2]\n"));
    for name in ["key.toml", "base.toml", "value.toml", "sweep.toml"] {
        let error = refusal(&folder, &["check", name]);
        assert!(error.len() < 3000, "{name}: {error}");
    }
    let error = refusal(&folder, &["check", "keys.toml"]);
    assert!(error.matches("there is no key").count() == 20 && error.contains("and 19980 more"), "{error}");
    assert!(refusal(&folder, &["check", "paper/classical", "--set", &format!("{long}=1")]).len() < 3000);
    assert!(refusal(&folder, &["explain", &long]).len() < 300);
}

#[test]
fn a_tick_beyond_the_recording_and_an_absurd_encoder_are_errors() {
    let folder = TestFolder::new();
    let tick = refusal(&folder, &["run", "paper/augmented", "--set", "simulation.tick_s=1e9"]);
    assert!(tick.contains("simulation.tick_s is 1000000000,") && tick.contains("length of the recording"), "{tick}");
    let step = refusal(&folder, &["run", "paper/augmented", "--set", "sensor.position_resolution_m=1e12"]);
    assert!(step.contains("sensor.position_resolution_m is 1e12"), "{step}");
}
