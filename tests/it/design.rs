//! Designs on the command line: identical files for any threads and interruptions; scenarios that run; invalid designs.

use std::process::Command;
use std::time::Duration;

use crate::support;
use crate::support::test_folder::TestFolder;

/// A short insertion with one event, numbers and choices, two objectives, and every kind of constraint.
const SMALL: &str = r#"
base = "builtin:layers/skin-augmented.toml"
persons = ["attentive", "distracted"]
[set]
simulation.duration_s = 3.5
[patients]
tissue.layer.skin.rupture_force_n = { median = 5.3, spread = 1.2 }
operator.movement_s = { from = 4.0, to = 6.0 }
[free]
augmentation.min_hold_s = { from = 0.05, to = 0.4 }
augmentation.catch_up_speed_m_per_s = { from = 0.003, to = 0.1, log = true }
augmentation.reengage = ["ramp", "snap", "clutch"]
[objectives.excess]
minimise = "rupture_excess_advance_m"
[objectives.noticed]
maximise = "rupture_noticed"
[constraints.force]
metric = "max_tissue_force_n"
at_most = 8.0
quantile = 0.9
[constraints.reached]
metric = "reached_share"
at_least = 0.8
[constraints.margin]
metric = "stability_gain_margin"
at_least = 1.0
[training]
patients = 8
[validation]
patients = 6
seeds = 2
[search]
candidates = 12
generations = 6
front = 4
"#;

const FILES: [&str; 6] =
    ["design.json", "candidates.csv", "designed.toml", "front/01.toml", "search.json", "design.toml"];

fn designs() -> TestFolder {
    let folder = TestFolder::new();
    folder.file("small.toml", SMALL);
    folder
}

fn same(folder: &TestFolder, a: &str, b: &str) {
    for file in FILES {
        assert!(folder.text(&format!("{a}/{file}")) == folder.text(&format!("{b}/{file}")), "{file}");
    }
}

#[test]
#[ignore = "more than 5 s of processor time"]
fn the_files_do_not_depend_on_the_threads_and_the_designs_run() {
    let folder = designs();
    let text = folder.good(&["design", "small.toml", "--no-figures", "--threads", "1", "--out", "one"]);
    for part in ["the knee", "training", "validation", "freeze-decay", "as good as the knee", "binds"] {
        assert!(text.contains(part), "{part}: {text}");
    }
    folder.good(&["design", "small.toml", "--no-figures", "--quiet", "--threads", "3", "--out", "three"]);
    same(&folder, "one/small", "three/small");
    // The designed scenario runs with the designed settings.
    let designed = folder.text("one/small/designed.toml");
    assert!(designed.contains("catch_up_speed_m_per_s = ") && designed.contains("duration_s = 3.5"), "{designed}");
    folder.good(&["run", "one/small/designed.toml", "one/small/front/01.toml", "--no-figures", "--quiet"]);
    let json: serde_json::Value = serde_json::from_str(&folder.text("one/small/design.json")).expect("JSON");
    let knees = json["designs"].as_array().expect("a list").iter().filter(|design| design["is_knee"] == true).count();
    assert_eq!((knees, json["designs"][0]["training"].as_array().map(Vec::len)), (1, Some(5)));
    // Other patients and noise give other values.
    assert_ne!(json["designs"][0]["training"], json["designs"][0]["validation"]);
}

#[test]
#[ignore = "more than 5 s of processor time"]
fn a_design_killed_five_times_continues_to_the_same_bytes() {
    let folder = designs();
    folder.good(&["design", "small.toml", "--no-figures", "--quiet", "--out", "undisturbed"]);
    let mut moments = crate::output::Moments::new();
    let mut kept = vec![];
    for _ in 0..5 {
        let mut child = folder.begin(&["design", "small.toml", "--no-figures", "--quiet"]);
        std::thread::sleep(Duration::from_secs_f64(1e-3 * (50.0 + 600.0 * moments.next())));
        let _ = child.kill();
        child.wait().expect("ended");
        let state = std::fs::read_to_string(folder.path("out/small/search.json")).unwrap_or_default();
        let state: serde_json::Value = serde_json::from_str(&state).unwrap_or_default();
        kept.push(state["generations"].as_u64().unwrap_or(0));
        assert!(kept.is_sorted(), "generations are lost: {kept:?}");
    }
    folder.good(&["design", "small.toml", "--no-figures", "--quiet"]);
    same(&folder, "undisturbed/small", "out/small");
    // A complete search is not repeated.
    let again = folder.trocar(&["design", "small.toml", "--no-figures"]);
    assert!(again.err.contains("continuing after generation 6 of 6"), "{}", again.err);
    same(&folder, "undisturbed/small", "out/small");
}

#[test]
fn an_interrupted_design_says_what_is_kept() {
    let folder = designs();
    folder.file("small.toml", SMALL.replace("generations = 6", "generations = 5000"));
    let child = folder.begin(&["design", "small.toml", "--no-figures"]);
    let state = folder.path("out/small/search.json");
    while !state.exists() {
        std::thread::sleep(Duration::from_millis(20));
    }
    let sent = Command::new("kill").args(["-INT", &child.id().to_string()]).status().expect("sent");
    assert!(sent.success());
    let output = child.wait_with_output().expect("ended");
    let message = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(130), "{message}");
    assert!(message.contains("of 5000 generations are kept in out/small; run the same command"), "{message}");
}

#[test]
fn the_shipped_designs_are_valid() {
    let folder = TestFolder::new();
    let liver = support::file("designs/liver.toml");
    let text = folder.good(&["check", liver.to_str().expect("a path")]);
    assert!(text.contains("liver: valid design"), "{text}");
}

#[test]
#[ignore = "more than 5 s of processor time"]
fn the_search_of_another_design_is_kept() {
    let folder = designs();
    let short = SMALL.replace("generations = 6", "generations = 1");
    folder.file("small.toml", &short);
    folder.good(&["design", "small.toml", "--no-figures", "--quiet"]);
    folder.file("small.toml", short.replace("at_most = 8.0", "at_most = 7.0"));
    folder.refused(
        &["design", "small.toml", "--no-figures"],
        &["holds the search of another design", "- constraints.force.at_most = 8.0", "--overwrite"],
    );
    folder.good(&["design", "small.toml", "--no-figures", "--quiet", "--overwrite"]);
    folder.good(&["check", "small.toml"]);
    folder.refused(&["run", "small.toml"], &["is a design file, not a scenario", "trocar design small.toml"]);
}

#[test]
fn invalid_designs_are_refused_with_their_line_and_a_remedy() {
    let folder = TestFolder::new();
    let changes: [(&str, &str, &[&str]); 17] = [
        ("[free]", "[fre]", &["a design has no key fre.augmentation.min_hold_s", "wrong.toml:"]),
        (
            "min_hold_s",
            "min_hld_s",
            &["there is no key augmentation.min_hld_s", "did you mean augmentation.min_hold_s"],
        ),
        ("to = 0.4 }", "to = 0.4, points = 3 }", &["free.augmentation.min_hold_s has points", "the search chooses"]),
        (
            "{ from = 0.05, to = 0.4 }",
            "{ median = 0.1, spread = 1.5 }",
            &["free.augmentation.min_hold_s is a distribution"],
        ),
        ("[\"ramp\", \"snap\", \"clutch\"]", "[\"ramp\"]", &["has one choice only", "write set.augmentation.reengage"]),
        ("rupture_noticed", "rupture_notice", &["there is no metric rupture_notice", "did you mean rupture_noticed"]),
        ("maximise", "maximize", &["objectives.noticed has no key maximize", "did you mean maximise"]),
        ("at_most = 8.0", "at_most = 8.0\nat_least = 1.0", &["constraints.force has at_least and at_most"]),
        ("at_least = 1.0", "certified = true", &["constraints.margin has metric and certified"]),
        ("quantile = 0.9", "quantile = 9", &["quantile is 9, must be a number from 0 to 1"]),
        ("\"distracted\"", "\"distrcted\"", &["there is no person distrcted", "did you mean distracted"]),
        ("simulation.duration_s = 3.5", "augmentation.reengage = \"snap\"", &["both free and set"]),
        ("simulation.duration_s = 3.5", "augmentation.hold = \"none\"", &["has no effect"]),
        (
            "operator.movement_s = { from = 4.0, to = 6.0 }",
            "augmentation.reengage = [\"ramp\", \"snap\"]",
            &["both free and in [patients]"],
        ),
        ("candidates = 12", "candidates = 1", &["must be a whole number from 4"]),
        ("metric = \"reached_share\"", "metric = \"port_hand_energy_j\"", &["port_"]),
        ("builtin:layers/skin-augmented.toml", "builtin:layers/skin-augmentd.toml", &["did you mean"]),
    ];
    folder.refused_changes("design", SMALL, &changes);
    let without =
        |section: &str| SMALL.split("\n[").filter(|part| !part.starts_with(section)).collect::<Vec<_>>().join("\n[");
    folder.file("wrong.toml", without("objectives"));
    folder.refused(&["design", "wrong.toml"], &["at least one objective"]);
    folder.file("wrong.toml", without("free"));
    folder.refused(&["design", "wrong.toml"], &["at least one free key"]);
}

#[test]
fn a_design_that_nothing_meets_says_so() {
    let folder = designs();
    let text = SMALL.replace("generations = 6", "generations = 2").replace("at_most = 8.0", "at_most = 0.5");
    folder.file("small.toml", text);
    let text = folder.good(&["design", "small.toml", "--no-figures"]);
    assert!(text.contains("candidates meets all") && text.contains("force ("), "{text}");
    assert!(!folder.path("out/small/designed.toml").exists());
}
