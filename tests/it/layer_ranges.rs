//! The ranges of measurements of tissue: values outside are warnings with a reason, shipped values are inside, and the
//! book lists the ranges.

use std::path::Path;

use crate::support::test_folder::TestFolder;
use trocar::run::outside_measured;
use trocar::scenario::{Scenario, Source, shipped_questions};
use trocar::tissue::literature::{self, Bounds, MEASURED};
use trocar::tissue::{LAYER_KEYS, LayerKeys};
use trocar::warning::{Code, Warning};

const SKIN: &str = "layers/through-the-skin.toml";
const SKIN_NAME: &str = "layers/through-the-skin";

fn keys_of(keys: &LayerKeys) -> [(&'static str, &'static Bounds); 8] {
    [
        (keys.thickness_m, &literature::THICKNESS_M),
        (keys.stiffness_n_per_m, &literature::STIFFNESS_N_PER_M),
        (keys.stiffening_n_per_m2, &literature::STIFFENING_N_PER_M2),
        (keys.rupture_force_n, &literature::RUPTURE_FORCE_N),
        (keys.cutting_force_n, &literature::CUTTING_FORCE_N),
        (keys.damping_s_per_m, &literature::DAMPING_S_PER_M),
        (keys.friction_n_per_m, &literature::FRICTION_N_PER_M),
        (keys.grip_n, &literature::GRIP_N),
    ]
}

/// Every key with a range.
fn ranged() -> Vec<(&'static str, &'static Bounds)> {
    let shaft = [
        ("tissue.shaft_stiffness_n_per_m", &literature::SHAFT_STIFFNESS_N_PER_M),
        ("tissue.static_ratio", &literature::STATIC_RATIO),
        ("tissue.stick_speed_m_per_s", &literature::STICK_SPEED_M_PER_S),
        ("tissue.shaft_damping_n_s_per_m2", &literature::SHAFT_DAMPING_N_S_PER_M2),
    ];
    LAYER_KEYS.iter().flat_map(keys_of).chain(shaft).collect()
}

/// The warnings about a scenario's tissue, and its error, with a setting.
fn said(key: &str, value: f64) -> Result<Vec<Warning>, String> {
    let setting = format!("{key}={value:e}");
    let scenario = Scenario::load(&Source::Builtin(SKIN.into()), &[setting]).map_err(|error| error.message)?;
    Ok(outside_measured(&scenario))
}

#[test]
fn what_is_outside_the_measurements_is_a_warning_with_place_and_range() {
    for (key, bounds) in ranged() {
        for value in [bounds.low.next_down(), bounds.high.next_up()].into_iter().filter(|value| *value > 0.0) {
            // A relation between two keys may refuse the value.
            let Ok(warnings) = said(key, value) else { continue };
            let [warning] = &warnings[..] else { panic!("{key}={value:e}: {warnings:?}") };
            assert_eq!((warning.code, warning.place.as_deref()), (Code::OutsideMeasured, Some(key)));
            assert!(warning.message.starts_with(key) && warning.message.ends_with(bounds.stated), "{warning}");
            assert!(warning.remedy.is_some());
        }
        for value in [bounds.low, bounds.high] {
            assert!(
                said(key, value).is_ok_and(|found| found.is_empty()) || said(key, value).is_err(),
                "{key}={value:e}"
            );
        }
        assert!(said(key, -1.0).is_err_and(|message| message.starts_with(key)), "{key}");
    }
}

#[test]
fn a_firm_phantom_runs_with_a_warning() {
    let folder = TestFolder::new();
    let firm = ["tissue.skin.rupture_force_n=30", "tissue.skin.stiffness_n_per_m=5000", "simulation.duration_s=1"];
    let set: Vec<&str> = firm.iter().flat_map(|setting| ["--set", setting]).collect();
    let run = [&["run", SKIN_NAME][..], &set].concat();
    // Warnings are wrapped at the width of the terminal.
    let unwrapped = |text: &str| text.split_whitespace().collect::<Vec<_>>().join(" ");
    let told = "tissue.skin.rupture_force_n is 30, outside of 0.0005 to 19.2 N";
    let (run, check) = (folder.trocar(&run), folder.trocar(&[&["check", SKIN_NAME][..], &set].concat()));
    assert!(run.code == 0 && unwrapped(&run.err).contains(told), "{}", run.err);
    assert!(check.code == 0 && unwrapped(&check.err).contains(told), "{}", check.err);
}

#[test]
fn what_ships_lies_in_the_ranges() {
    let mut seen = 0;
    for (name, _) in shipped_questions() {
        let scenario = Scenario::load(&Source::Builtin(name.into()), &[]).expect("ships");
        let echo: toml::Table = scenario.echo().parse().expect("TOML");
        if echo["tissue"]["kind"].as_str() != Some("layers") {
            continue;
        }
        seen += 1;
        for (key, bounds) in ranged() {
            let at = key.split('.').skip(1).try_fold(&echo["tissue"], |table, part| table.get(part));
            let value = at.and_then(toml::Value::as_float).expect("a number");
            assert!(bounds.contains(value), "{name}: {key} = {value}");
        }
    }
    assert!(seen >= 3, "{seen}");
}

#[test]
fn the_book_lists_what_was_measured() {
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
