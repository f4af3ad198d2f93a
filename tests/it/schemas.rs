//! The schema of every kind of file agrees with files that commands write.

use std::process::{Command, Stdio};

use serde_json::{Value as Json, json};

use crate::support::test_folder::TestFolder;

const SCENARIO: &str = "name = \"x\"\nbase = \"layers/skin-augmented\"\n[simulation]\nduration_s = 2.5\n";
const SWEEP: &str = "name = \"s\"\nbase = \"x.toml\"\nmetrics = [\"max_excess_advance_m\", \"false_alarms\"]\nfocus = [\"max_excess_advance_m\"]\n\
    [design]\nkind = \"sobol\"\npoints = 8\n[axes]\nscaling.force = { from = 0.5, to = 2.0 }\n";

const DESIGN: &str = "name = \"d\"\nbase = \"x.toml\"\n[patients]\noperator.movement_s = { from = 4.0, to = 6.0 }\n[free]\n\
    augmentation.min_hold_s = { from = 0.1, to = 0.4 }\naugmentation.reengage = [\"ramp\", \"snap\"]\n[objectives.overshoot]\n\
    minimise = \"max_slave_overshoot_m\"\n[objectives.contrast]\nmaximise = \"min_felt_contrast\"\nquantile = 0.1\n\
    [constraints.force]\nmetric = \"max_tissue_force_n\"\nat_most = 9.0\n[training]\npatients = 4\n[validation]\npatients = 3\n\
    seeds = 1\n[search]\ncandidates = 4\ngenerations = 2\n";

/// The kind of a file, the command that writes it, and its path.
type Case = (&'static str, &'static str, &'static str);

/// The files whose content `--json` also prints.
const PRINTED: &[Case] = &[
    ("run", "run x.toml", "out/x/summary.json"),
    ("run", "run layers/epidural --set channel.delay_s=0.2 --set scaling.force=1000", "out/epidural/summary.json"),
    ("run", "run link/long-delay", "out/long-delay/summary.json"),
    ("comparison", "compare", "out/compare/comparison.json"),
    ("comparison", "compare x.toml layers/epidural --seeds 2", "out/compare/comparison.json"),
    ("comparison", "strategies --schemes x.toml", "out/strategies/comparison.json"),
    ("strategies", "strategies x.toml --seeds 2", "out/strategies/strategies.json"),
    ("detection", "detect a/two.csv --no-figures", "out/two/detection.json"),
    ("detection", "detect a/two.csv --no-figures --rupture-s 0.5 --rupture-s 1", "out/two/detection.json"),
    ("detections", "detect a --no-figures", "out/detect/detections.json"),
    ("calibration", "calibrate paper/augmented", "out/augmented/calibration.json"),
    (
        "identification",
        "identify machine.csv --time t --master m --slave s --force f --no-figures",
        "out/machine/identification.json",
    ),
    ("roc", "roc x.toml --seeds 2 --thresholds 3", "out/roc/roc.json"),
    ("sweep", "sweep s.toml", "out/s/summary.json"),
    ("design", "design d.toml --no-figures", "out/d/design.json"),
    (
        "stability",
        "stability --x scaling.force=0.1:4:4 --y channel.delay_s=0:0.1:3",
        "out/depth-classical/stability.json",
    ),
    (
        "stability",
        "stability x.toml --x scaling.force=0.1:4:4 --y channel.delay_s=0:0.1:3 --z-width 0:10:3 --arms 8 --simulate \
         --absolute channel.delay_s=0:0.05:3 --hand 1:50 --tissue 50:400 --event-limits",
        "out/x/stability.json",
    ),
];

/// The files that `--json` does not print, and the outputs of commands that write no file.
const OTHERS: &[Case] = &[
    ("paper", "paper --quiet", "out/paper/paper.json"),
    ("manifest", "sweep s.toml", "out/s/manifest.json"),
    ("files", "run x.toml", "out/x/manifest.json"),
    ("files", "compare x.toml", "out/compare/manifest.json"),
    ("certificate", "stability x.toml --x scaling.force=0.1:4:4 --y channel.delay_s=0:0.1:3", "out/x/certificate.json"),
    ("signals", "detect --list a/two.csv --json", ""),
    ("check", "check x.toml s.toml d.toml link/long-delay paper/augmented --json", ""),
    ("scenarios", "scenarios --json", ""),
];

/// The optional keys of objects, and the objects whose keys are names or settings.
const OPTIONAL: [&str; 11] = [
    "also",
    "further_estimate",
    "is_jitter_unlimited",
    "jitter_s",
    "jitter_ticks",
    "missed",
    "schemes",
    "seeds",
    "source",
    "spaces",
    "warnings",
];
const NAMES: [&str; 7] =
    ["/certificates", "/files", "/parameters", "/spaces", "/settings/", "/sensitivities/", "/missed"];

fn folder() -> TestFolder {
    let folder = TestFolder::new();
    folder.file("x.toml", SCENARIO).file("s.toml", SWEEP).file("d.toml", DESIGN);
    // A slave that follows its master with a delay, against a spring.
    let machine = (0..600).map(|k| {
        let place = |t: f64| 0.01 * (9.0 * t).sin();
        let (t, slave) = (f64::from(k) * 1e-3, place(f64::from(k) * 1e-3 - 0.01));
        format!("{t:.3},{:.7},{slave:.7},{:.5}\n", place(t), 300.0 * slave.max(0.0))
    });
    let machine: String = std::iter::once("t,m,s,f\n".to_owned()).chain(machine).collect();
    folder.file("machine.csv", &machine);
    folder
        .file("a/two.csv", crate::output::insertion())
        .file("a/bad.csv", "time_s,position_m,force_n\n0,0,0\n0.001,soft,0\n");
    folder
}

fn parsed(text: &str) -> Json {
    serde_json::from_str(text).expect("JSON")
}

fn schema(folder: &TestFolder, kind: &str) -> Json {
    parsed(&folder.good(&["schema", kind]))
}

fn kinds(folder: &TestFolder) -> Vec<String> {
    let help = folder.good(&["schema", "--help"]);
    let name = |line: &str| Some(line.trim_start().strip_prefix("- ")?.split_once(':')?.0.to_owned());
    help.lines().filter_map(name).collect()
}

/// Returns the places of the objects of a value; for a list, those of its first entry.
fn objects(value: &Json, place: &str, found: &mut Vec<String>) {
    match value {
        Json::Object(map) => {
            found.push(place.to_owned());
            map.iter().for_each(|(key, value)| objects(value, &format!("{place}/{key}"), found));
        }
        Json::Array(list) => list.iter().take(1).for_each(|value| objects(value, &format!("{place}/0"), found)),
        _ => {}
    }
}

fn object<'a>(value: &'a mut Json, place: &str) -> &'a mut serde_json::Map<String, Json> {
    value.pointer_mut(place).and_then(Json::as_object_mut).expect("an object")
}

/// Checks that a file has the keys of its schema, and that the schema rejects the file with an unknown key or without
/// a key.
fn check(case: &Case, schema: &Json, content: &Json) {
    let validator = jsonschema::validator_for(schema).expect("a schema");
    let errors: Vec<String> =
        validator.iter_errors(content).map(|error| format!("{}: {error:.300}", error.instance_path())).collect();
    assert!(errors.is_empty(), "{case:?}: {errors:#?}");
    let mut places = vec![];
    objects(content, "", &mut places);
    for place in &places {
        let mut more = content.clone();
        object(&mut more, place).insert("unknown".into(), json!({ "unknown": {} }));
        assert!(!validator.is_valid(&more), "{case:?}: an unknown key at {place}");
        if NAMES.iter().any(|of_names| format!("{place}/").contains(of_names)) {
            continue;
        }
        let keys: Vec<String> = object(&mut content.clone(), place).keys().cloned().collect();
        for key in keys.iter().filter(|key| !OPTIONAL.contains(&key.as_str())) {
            let mut less = content.clone();
            object(&mut less, place).remove(key);
            assert!(!validator.is_valid(&less), "{case:?}: {place} without {key}");
        }
    }
}

fn words(command: &str) -> Vec<&str> {
    command.split_whitespace().collect()
}

#[test]
#[ignore = "two minutes of processor time"]
fn a_file_has_the_keys_of_its_schema_and_json_prints_the_same_bytes() {
    for case @ (kind, command, file) in PRINTED {
        let folder = folder();
        let printed = folder.trocar(&[&words(command)[..], &["--json"]].concat()).out;
        assert!(printed == folder.text(file), "{case:?}: the output is not the file");
        check(case, &schema(&folder, kind), &parsed(&printed));
    }
}

#[test]
#[ignore = "two minutes of processor time"]
fn other_files_and_outputs_have_the_keys_of_their_schema() {
    for case @ (kind, command, file) in OTHERS {
        let folder = folder();
        let printed = folder.good(&words(command));
        let content = if file.is_empty() { printed } else { folder.text(file) };
        check(case, &schema(&folder, kind), &parsed(&content));
    }
}

#[test]
fn the_summary_of_a_link_has_the_keys_of_its_schema() {
    let folder = folder();
    let start = |side: &[&str]| {
        let mut command = Command::new(assert_cmd::cargo::cargo_bin("trocar"));
        command.current_dir(folder.path("")).arg("link").args(side).args(["x.toml", "--json"]);
        command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("starts")
    };
    let mut slave = start(&["slave", "--listen", "127.0.0.1:0"]);
    let mut line = String::new();
    let mut printed = std::io::BufReader::new(slave.stderr.take().expect("a pipe"));
    std::io::BufRead::read_line(&mut printed, &mut line).expect("a line");
    let address = line.split_whitespace().find_map(|word| word.strip_suffix(';')).expect("an address");
    let master = start(&["master", "--to", address]);
    for (side, process) in [("master", master), ("slave", slave)] {
        let printed = String::from_utf8(process.wait_with_output().expect("ends").stdout).expect("text");
        assert_eq!(printed, folder.text(&format!("out/x/{side}/summary.json")));
        check(&("link", side, ""), &schema(&folder, "link"), &parsed(&printed));
    }
}

#[test]
fn scenario_sweep_and_design_files_have_the_keys_of_their_schema() {
    let folder = folder();
    for (kind, file) in [("scenario", "x.toml"), ("sweep-file", "s.toml"), ("design-file", "d.toml")] {
        let content: Json = toml::from_str(&folder.text(file)).expect("TOML");
        let validator = jsonschema::validator_for(&schema(&folder, kind)).expect("a schema");
        assert!(validator.is_valid(&content), "{kind}");
        let mut more = content.clone();
        more["unknown"] = 1.into();
        assert!(!validator.is_valid(&more), "{kind}");
    }
    assert_eq!(folder.good(&["schema"]), folder.good(&["schema", "scenario"]));
}

#[test]
fn every_kind_is_tested_and_every_key_has_a_meaning() {
    let folder = folder();
    let kinds = kinds(&folder);
    let others = ["scenario", "sweep-file", "design-file", "link"];
    let tested: Vec<&str> = PRINTED.iter().chain(OTHERS).map(|(kind, ..)| *kind).chain(others).collect();
    assert!(kinds.len() >= 18 && kinds.iter().all(|kind| tested.contains(&kind.as_str())), "{kinds:?}");
    assert!(tested.iter().all(|kind| kinds.iter().any(|other| other == kind)), "{kinds:?}");
    let completions = folder.good(&["completions", "bash"]);
    for kind in &kinds {
        assert!(completions.contains(kind), "{kind}");
        let schema = schema(&folder, kind);
        assert_eq!(schema["title"], format!("trocar {kind}"));
        // The keys of an axis are the same everywhere, and the manual explains them.
        if !matches!(kind.as_str(), "sweep-file" | "design-file") {
            check_meanings(&schema, kind);
        }
    }
}

/// Checks that every property of a schema has a description, a type with a description, or a single value.
fn check_meanings(schema: &Json, place: &str) {
    let Json::Object(map) = schema else {
        schema.as_array().into_iter().flatten().for_each(|part| check_meanings(part, place));
        return;
    };
    for (key, property) in map.get("properties").and_then(Json::as_object).into_iter().flatten() {
        let is_described = ["description", "$ref", "const"].iter().any(|keyword| property.get(keyword).is_some());
        assert!(is_described || property["anyOf"][0]["$ref"].is_string(), "{place}: {key} has no description");
    }
    map.iter().for_each(|(key, part)| check_meanings(part, &format!("{place}/{key}")));
}
