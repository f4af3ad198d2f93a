//! Loading any file gives a scenario or an error, and the echo of a resolved scenario loads to the same scenario.

use proptest::prelude::*;
use trocar::metrics::RunMetric;
use trocar::scenario::{Fallback, KEYS, Key, Kind, Scenario, Source, Starter, find_key, json_schema};

fn load(text: &[u8]) -> Result<Scenario, String> {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("scenario.toml");
    std::fs::write(&path, text).expect("written");
    Scenario::load(&Source::Disk(path), &[]).map_err(|error| error.to_string())
}

/// Numbers at the limits of keys, and words that some keys allow.
const EXTREMES: &str = "0 1 1e-12 1e-6 1e-3 0.5 10 1e3 1e6 1e9 1e12 -1e12 -1 true false [1e12] [1e-12,1e12] \
    [1e12,1,1] [1,0,0,0] [1,1e12,1,1] 'as-printed' 'reference' 'snap' 'clutch' 'amplify' 'mean-change' \
    'variance-change' 'parameter-change' 'force-derivative'";

/// Values of every kind, most of which most keys refuse.
const VALUES: &str = "0 -1 nan inf -inf 1e308 1e-320 true '' 'ramp' 'recording' [] [0.0] [1,2,3] [nan] {} {a=1} 'x' \
    1979-05-27 'as-printed' '../../etc' 'builtin:none'";

fn one_of(values: &'static str) -> impl Strategy<Value = String> {
    prop::sample::select(values.split(' ').collect::<Vec<_>>()).prop_map(str::to_owned)
}

fn any_value() -> impl Strategy<Value = String> {
    prop_oneof![
        any::<f64>().prop_map(|v| format!("{v:?}").replace("NaN", "nan")),
        any::<i64>().prop_map(|v| v.to_string()),
        one_of(VALUES),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn arbitrary_bytes_do_not_panic(bytes in prop::collection::vec(any::<u8>(), 0..400)) {
        let _ = load(&bytes);
    }

    #[test]
    fn arbitrary_text_does_not_panic(text in "[\\[\\]a-z_.=\"'0-9\\n {},#-]{0,200}") {
        let _ = load(text.as_bytes());
    }

    #[test]
    fn arbitrary_values_of_known_keys_do_not_panic(
        entries in prop::collection::vec((0..KEYS.len(), any_value()), 1..6),
    ) {
        // Without the recording a case is quick. Long runs are refused or only resolved.
        let mut text = String::from("operator.kind = \"ramp\"\ntissue.kind = \"kelvin-voigt\"\n");
        for (index, value) in entries {
            if !KEYS[index].path.ends_with("kind") {
                text.push_str(&format!("{} = {value}\n", KEYS[index].path));
            }
        }
        let _ = load(text.as_bytes());
    }

    #[test]
    fn every_run_gives_finite_values(
        entries in prop::collection::vec((0..KEYS.len(), one_of(EXTREMES)), 1..4),
    ) {
        let mut text = String::from("operator.kind = \"ramp\"\ntissue.kind = \"kelvin-voigt\"\nsimulation.duration_s = 0.2\n");
        for (index, value) in entries {
            if !KEYS[index].path.ends_with("kind") && !KEYS[index].path.starts_with("simulation") {
                text.push_str(&format!("{} = {value}\n", KEYS[index].path));
            }
        }
        if let Ok(scenario) = load(text.as_bytes()) {
            let run = trocar::run::run(scenario).expect("the exact engine always comes to a result");
            for (name, column) in trocar::engine::COLUMNS.iter().zip(run.trace.numbers()) {
                prop_assert!(column.iter().all(|value| value.is_finite()), "{name} of\n{text}");
            }
            let metrics = &run.metrics;
            for metric in RunMetric::of_run_with(metrics.ruptures.len(), metrics.events.len()) {
                prop_assert!(metric.read(metrics).is_none_or(f64::is_finite), "{} of\n{text}", metric.key());
            }
        }
    }

    #[test]
    fn the_echo_of_a_resolved_scenario_loads_to_the_same_scenario(
        scale in 0.1..3.0f64, tick in prop::sample::select(vec![1e-3, 5e-4, 2e-3]), k_v in 0.0..40.0f64,
        seed in 0..i64::MAX, ratio in 0.0..=1.0f64, reengage in prop::sample::select(vec!["ramp", "fade", "when-still", "clutch", "snap"]),
        distance in prop::sample::select(trocar::detector::DistanceKind::WORDS.to_vec()),
    ) {
        let text = format!(
            "operator.kind = \"ramp\"\ntissue.kind = \"kelvin-voigt\"\nscaling.force = {scale:?}\n\
             simulation = {{ tick_s = {tick:?}, seed = {seed} }}\nslave.velocity_gain = {k_v:?}\n\
             augmentation = {{ decay_ratio = {ratio:?}, reengage = \"{reengage}\" }}\ndetector.distance = \"{distance}\"\n"
        );
        let scenario = load(text.as_bytes()).expect("good");
        let again = load(scenario.echo().as_bytes()).expect("its echo is good");
        prop_assert_eq!(scenario.echo(), again.echo());
        prop_assert_eq!(scenario.detector, again.detector);
        prop_assert_eq!(scenario.augmentation, again.augmentation);
        prop_assert_eq!(scenario.estimator, again.estimator);
        prop_assert_eq!((scenario.grid, scenario.seed, scenario.slave), (again.grid, again.seed, again.slave));
    }
}

#[test]
fn the_starter_is_valid_unchanged_and_with_every_default_uncommented() {
    let text = Starter::All.text("mine");
    assert_eq!(load(text.as_bytes()).expect("good").name, "mine");
    // Keys for other kinds than the starter's have no effect and would be refused.
    let values = load(text.as_bytes()).expect("good");
    let acts = |path: String| find_key(&path).is_some_and(|key| values.values().is_acting(&key));
    let mut active = String::new();
    let mut section = String::new();
    for line in text.lines() {
        if let Some(name) = line.strip_prefix('[') {
            section = format!("{}.", name.trim_end_matches(']'));
        }
        let key = line.strip_prefix("# ").and_then(|rest| rest.split_once(" = "));
        match key {
            Some((name, value))
                if !name.contains(' ') && !value.starts_with('#') && acts(format!("{section}{name}")) =>
            {
                active.push_str(&line[2..]);
            }
            _ => active.push_str(line),
        }
        active.push('\n');
    }
    let has_default = |key: &&Key| matches!(key.fallback, Fallback::Value(_));
    let defaults = KEYS.iter().filter(has_default).filter(|key| values.values().is_acting(key)).count();
    assert!(active.lines().filter(|line| !line.starts_with('#') && line.contains(" = ")).count() >= defaults);
    load(active.as_bytes()).expect("every default is allowed");
}

#[test]
fn the_schema_knows_every_key_and_default() {
    let schema = json_schema();
    for key in KEYS {
        let mut at = &schema;
        for part in key.path.split('.') {
            at = &at["properties"][part];
        }
        assert!(at["description"].is_string(), "{}", key.path);
        if let Fallback::Value(value) = key.fallback {
            assert_eq!(
                at["default"],
                serde_json::to_value(trocar::scenario::Value::from(value).to_toml()).expect("json"),
                "{}",
                key.path
            );
        }
        if let Kind::Choice(words) = key.kind {
            assert_eq!(at["enum"], serde_json::to_value(words).expect("json"), "{}", key.path);
        }
    }
}
