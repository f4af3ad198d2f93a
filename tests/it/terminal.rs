//! Printed output: tables of 80 columns, a short comparison with a sentence, help that is wrapped once, and manual
//! pages.

use std::fs;

use crate::support::scenario;
use crate::support::test_folder::{TestFolder, words};

/// Maximum width of printed lines, in characters.
const WIDTH: usize = 80;

const PAIR: [&str; 2] = ["builtin:layers/through-the-skin.toml", "builtin:layers/skin-augmented.toml"];

fn assert_fits(printed: &str, what: &str) {
    for line in printed.lines() {
        assert!(line.chars().count() <= WIDTH, "{what}: {line:?} in\n{printed}");
    }
}

#[test]
#[ignore = "more than 5 s of processor time"]
fn every_command_prints_lines_of_at_most_80_characters() {
    let folder = TestFolder::new();
    let recording = folder.good(&["record", "--out", "-"]);
    for name in ["one", "two"] {
        folder.file(&format!("trials/{name}-insertion.csv"), &recording);
    }
    let labels = "file,time_s,kind\none-insertion.csv,5.52,capsule\none-insertion.csv,8.85,membrane\n";
    folder.file("labels.csv", format!("{labels}two-insertion.csv,5.52,capsule\ntwo-insertion.csv,6.5,membrane\n"));
    folder.file(
        "sweep.toml",
        "base = \"builtin:paper/augmented.toml\"\nseeds = 2\n[axes]\nscaling.force = [1.0, 1.2]\n\
         detector.threshold = [0.01, 0.02]\naugmentation.reengage = [\"ramp\", \"snap\"]\n",
    );
    let axes = ["--x", "scaling.force=0.1:10:4", "--y", "tissue.stiffness_n_per_m=10:20000:4"];
    let lines: [&[&str]; 22] = [
        &["compare"],
        &["compare", "--all"],
        &["paper"],
        &["strategies", "--seeds", "2", "--persons", "attentive"],
        &["compare", "--seeds", "2", PAIR[0], PAIR[1]],
        &[
            "compare",
            "--all",
            PAIR[0],
            PAIR[1],
            "builtin:hand/reflex-augmented.toml",
            "builtin:sensing/sensor-not-ideal.toml",
        ],
        &["compare", PAIR[1]],
        &["compare", "--set", "master.coupling=as-printed"],
        &["run", PAIR[1], "builtin:link/outage-at-the-rupture.toml"],
        &["detect", "builtin:in_vivo_like.csv"],
        &["detect", "builtin:paper/real-augmented.toml"],
        &["detect", "trials", "--labels", "labels.csv", "--no-figures"],
        &["detect", "trials", "--no-figures", "--contact-m", "1"],
        &["calibrate", "builtin:in_vivo_like.csv"],
        &["calibrate", "builtin:in_vivo_like.csv", "--first-s", "2"],
        &["roc", "--seeds", "1", "--thresholds", "3", "--noise-std-n", "0.01,0.025", "--drop-n", "1,2"],
        &["stability", axes[0], axes[1], axes[2], axes[3], "--simulate"],
        &["stability", PAIR[1], axes[0], axes[1], axes[2], axes[3]],
        &["sweep", "sweep.toml"],
        &["check", PAIR[0]],
        &["init", "mine.toml"],
        &["record"],
    ];
    for line in lines {
        assert_fits(&folder.good(line), &line.join(" "));
    }
    let live = folder.fed(&["detect", "-", "--velocity", "velocity_m_per_s"], recording.as_bytes());
    assert_eq!(live.code, 0, "{}", live.err);
    assert_fits(&live.err, "detect -");
}

#[test]
#[ignore = "more than 5 s of processor time"]
fn a_comparison_is_short_and_states_its_conclusion() {
    let folder = TestFolder::new();
    let table = |printed: &str| printed.split("\n\n").nth(1).unwrap_or_default().lines().count();
    let printed = folder.good(&["compare"]);
    // A heading and its rule, eight rows for each of two ruptures, and three rows for the run.
    assert_eq!(table(&printed), 2 + 2 * 8 + 3, "{printed}");
    let sentence = words(&printed);
    let expected = "classical and augmented: In the 0.3 s after both ruptures the slave advances by 8.95 and 5.75 mm without \
                    augmentation and stays within 0.0058 mm with it. On its return it advances by 9.35 and 7.59 mm with it; 2 s after \
                    both ruptures both are equally deep (11 and 11.9 mm). Both runs detect every rupture within 8 ms, with no missed \
                    rupture and no false alarm.";
    assert!(sentence.starts_with(expected), "{printed}");
    assert!(!printed.contains("statement") && !printed.contains("in noise"), "{printed}");
    let all = folder.good(&["compare", "--all"]);
    assert!(all.contains("in noise: false samples") && all.contains("stays within"), "{all}");
    let paper = folder.good(&["paper"]);
    for judgement in ["reproduced", "contradicted", "not checkable"] {
        assert!(paper.lines().filter(|line| line.ends_with(judgement)).count() >= 5, "{judgement}: {paper}");
    }
    let other = folder.good(&["compare", PAIR[0], "layers/skin-augmented"]);
    assert!(other.contains("The first 2 of 3 ruptures; --all shows the others."), "{other}");
}

/// Every output shows the same sentences.
#[test]
fn terminal_report_json_page_and_python_show_the_same_sentences() {
    let folder = TestFolder::new();
    let printed = folder.said(&["compare", PAIR[0], PAIR[1], "--report"]);
    let report = words(&folder.text("out/compare/report.html"));
    let runs = PAIR.map(|name| trocar::run::run(scenario(name, &[])).expect("a run"));
    // The page of `trocar explore` sends this text; the report and the terminal render the document with it.
    let page = trocar::compare::verdict_of_schemes(&runs[0], &runs[1]);
    assert_eq!(page, trocar::compare::verdict(&runs.each_ref()));
    for sentence in &page.sentences {
        assert!(printed.contains(sentence), "{sentence}: {printed}");
        assert!(report.contains(sentence), "{sentence}");
    }
}

#[test]
fn a_change_is_printed_only_where_it_has_a_meaning() {
    let folder = TestFolder::new();
    let printed = folder.good(&["compare", "--all"]);
    let row = |label: &str| printed.lines().find(|line| line.starts_with(label)).expect("a row").to_owned();
    assert!(row("rupture 1: overshoot in 0.5 s").ends_with("-99.8 %"), "{printed}");
    assert!(row("rupture 2: overshoot in 0.5 s").ends_with("-100 %"), "{printed}");
    // The sign of these metrics varies, and the first value of the last metric is 0.
    for label in ["rupture 2: overshoot at 0.3 s", "minimum tissue force", "final tracking error", "time augmented"] {
        assert!(!row(label).ends_with('%') || row(label).matches('%').count() == 2, "{printed}");
    }
    // Only a value of 0 is a change by 100 %.
    for line in printed.lines().filter(|line| line.contains("-100")) {
        let words: Vec<&str> = line.split_whitespace().rev().collect();
        assert_eq!((words[0], words[1], words[3]), ("%", "-100", "0"), "{line}");
    }
}

const NESTED: [[&str; 2]; 5] =
    [["scenarios", "show"], ["sweep", "merge"], ["link", "master"], ["link", "slave"], ["link", "replay"]];

#[test]
fn every_help_fits_is_wrapped_once_and_has_an_example() {
    let folder = TestFolder::new();
    let commands = folder.commands();
    let mut calls: Vec<Vec<&str>> = commands.iter().map(|command| vec![command.as_str()]).collect();
    calls.push(vec![]);
    calls.extend(NESTED.map(Vec::from));
    for call in calls {
        for flag in ["--help", "-h"] {
            assert_fits(&folder.good(&[&call[..], &[flag]].concat()), &call.join(" "));
        }
        let help = folder.good(&[&call[..], &["--help"]].concat());
        let block = |heading| Some(help.split(heading).nth(1)?.lines().take_while(|line| !line.is_empty()));
        let examples = block("Examples:\n").or_else(|| block("Example:\n"));
        let is_example = |line: &str| line.contains("trocar") && line.starts_with("  ");
        let mut shown = examples.clone().or_else(|| block("Live stream:\n")).into_iter().flatten();
        assert!(shown.any(is_example), "{call:?}\n{help}");
        // A line that is wrapped a second time would begin with a word of its description.
        for line in examples.into_iter().flatten() {
            let indent = line.len() - line.trim_start().len();
            assert!(indent >= 6 || indent == 2 && line.contains("trocar "), "{call:?}: {line:?}");
        }
    }
}

#[test]
fn every_command_has_its_manual_page() {
    let folder = TestFolder::new();
    let printed = folder.good(&["man", "--out", "pages"]);
    assert_fits(&printed, "man");
    assert!(folder.good(&["man"]).starts_with(".ie"), "troff");
    let mut expected: Vec<String> = folder.commands().iter().map(|command| format!("trocar-{command}.1")).collect();
    expected.push("trocar.1".to_owned());
    expected.extend(NESTED.map(|[command, nested]| format!("trocar-{command}-{nested}.1")));
    expected.sort();
    let pages = folder.files("pages");
    let names: Vec<String> = pages.keys().map(|path| path.display().to_string()).collect();
    assert_eq!(names, expected);
    for name in names {
        let page = fs::read_to_string(folder.path(&format!("pages/{name}"))).expect("a page").replace("\\-", "-");
        let title = name.trim_end_matches(".1");
        assert!(page.contains(&format!(".TH {title} ")), "{page}");
        assert!(page.contains("trocar ") && page.contains(".SH SYNOPSIS"), "{page}");
    }
}
