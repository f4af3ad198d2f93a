//! The ranges of tissue measurements: values outside give warnings with a reason, shipped values are inside, and the
//! book lists the ranges.

use std::path::Path;

use crate::support::test_folder::{TestFolder, words};
use trocar::run::outside_measured;
use trocar::scenario::{Scenario, Source, shipped_questions};
use trocar::tissue::literature::{self, Bounds, MEASURED};
use trocar::warning::{Code, Warning};

const SKIN: &str = "layers/through-the-skin.toml";
const SKIN_NAME: &str = "layers/through-the-skin";

const LAYERS: [&str; 5] = ["skin", "fat", "muscle", "capsule", "organ"];

const OF_LAYERS: [(&str, &Bounds); 8] = [
    ("thickness_m", &literature::THICKNESS_M),
    ("stiffness_n_per_m", &literature::STIFFNESS_N_PER_M),
    ("stiffening_n_per_m2", &literature::STIFFENING_N_PER_M2),
    ("rupture_force_n", &literature::RUPTURE_FORCE_N),
    ("cutting_force_n", &literature::CUTTING_FORCE_N),
    ("damping_s_per_m", &literature::DAMPING_S_PER_M),
    ("friction_n_per_m", &literature::FRICTION_N_PER_M),
    ("grip_n", &literature::GRIP_N),
];

const OF_SHAFT: [(&str, &Bounds); 4] = [
    ("shaft_stiffness_n_per_m", &literature::SHAFT_STIFFNESS_N_PER_M),
    ("static_ratio", &literature::STATIC_RATIO),
    ("stick_speed_m_per_s", &literature::STICK_SPEED_M_PER_S),
    ("shaft_damping_n_s_per_m2", &literature::SHAFT_DAMPING_N_S_PER_M2),
];

fn ranged() -> Vec<(String, &'static Bounds)> {
    let of_layer =
        |name: &'static str| OF_LAYERS.map(|(field, bounds)| (format!("tissue.layer.{name}.{field}"), bounds));
    let of_shaft = OF_SHAFT.map(|(field, bounds)| (format!("tissue.{field}"), bounds));
    LAYERS.into_iter().flat_map(of_layer).chain(of_shaft).collect()
}

/// Returns the warnings about a scenario's tissue with a setting, or its error.
fn said(key: &str, value: f64) -> Result<Vec<Warning>, String> {
    let setting = format!("{key}={value:e}");
    let scenario = Scenario::load(&Source::Builtin(SKIN.into()), &[setting]).map_err(|error| error.message)?;
    Ok(outside_measured(&scenario))
}

#[test]
fn a_value_outside_the_measurements_gives_a_warning_with_place_and_range() {
    for (key, bounds) in ranged() {
        for value in [bounds.low.next_down(), bounds.high.next_up()].into_iter().filter(|value| *value > 0.0) {
            // A relation between two keys may refuse the value.
            let Ok(warnings) = said(&key, value) else { continue };
            let [warning] = &warnings[..] else { panic!("{key}={value:e}: {warnings:?}") };
            assert_eq!((warning.code, warning.place.as_deref()), (Code::OutsideMeasured, Some(&*key)));
            assert!(warning.message.starts_with(&key) && warning.message.ends_with(bounds.stated), "{warning}");
            assert!(warning.remedy.is_some());
        }
        for value in [bounds.low, bounds.high] {
            assert!(
                said(&key, value).is_ok_and(|found| found.is_empty()) || said(&key, value).is_err(),
                "{key}={value:e}"
            );
        }
        assert!(said(&key, -1.0).is_err_and(|message| message.starts_with(&key)), "{key}");
    }
}

#[test]
fn a_firm_phantom_runs_with_a_warning() {
    let folder = TestFolder::new();
    let firm =
        ["tissue.layer.skin.rupture_force_n=30", "tissue.layer.skin.stiffness_n_per_m=5000", "simulation.duration_s=1"];
    let set: Vec<&str> = firm.iter().flat_map(|setting| ["--set", setting]).collect();
    for command in ["run", "check"] {
        let warned = words(&folder.warned(&[&[command, SKIN_NAME][..], &set].concat()));
        assert!(warned.contains("tissue.layer.skin.rupture_force_n is 30, outside of 0.0005 to 19.2 N"), "{warned}");
    }
}

#[test]
fn shipped_values_lie_in_the_ranges() {
    let mut seen = 0;
    for (name, _) in shipped_questions() {
        let scenario = Scenario::load(&Source::Builtin(name.into()), &[]).expect("ships");
        let echo: toml::Table = scenario.echo().parse().expect("TOML");
        if echo["tissue"]["kind"].as_str() != Some("layers") {
            continue;
        }
        seen += 1;
        let number = |table: &toml::Value, key: &str| table[key].as_float().expect("a number");
        let tissue = &echo["tissue"];
        for (key, bounds) in OF_SHAFT {
            assert!(bounds.contains(number(tissue, key)), "{name}: {key}");
        }
        for layer in tissue["layer"].as_array().expect("a list") {
            for (key, bounds) in OF_LAYERS {
                assert!(bounds.contains(number(layer, key)), "{name}: {layer:?}: {key}");
            }
        }
    }
    assert!(seen >= 3, "{seen}");
}

#[test]
fn the_book_lists_the_measured_ranges() {
    let page = std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/src/evidence/literature.md"))
        .expect("there");
    let mut from = 0;
    for row in &MEASURED {
        let span = |low: f64, high: f64| if low == high { format!("{low}") } else { format!("{low} to {high}") };
        let line = format!(
            "| {} | {} | {} | {} | {} |\n",
            row.quantity,
            span(row.low, row.high),
            row.tissue,
            row.source,
            span(row.bounds.low, row.bounds.high)
        );
        let at = page[from..].find(&line).unwrap_or_else(|| panic!("literature.md lacks, in its order: {line}"));
        from += at + line.len();
    }
}
