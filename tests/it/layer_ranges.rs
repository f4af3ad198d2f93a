//! The ranges of the keys of layers: values outside are rejected with a reason, shipped values are inside, and the
//! book lists the ranges.

use std::path::Path;

use crate::support::test_folder::TestFolder;
use trocar::scenario::{Scenario, Source, shipped_questions};
use trocar::tissue::literature::{self, Bounds, MEASURED};
use trocar::tissue::{LAYER_KEYS, LayerKeys};

const SKIN: &str = "layers/through-the-skin.toml";

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

/// Returns the next number outside of a bound; the bound itself is allowed.
fn just_outside(bounds: &Bounds) -> [f64; 2] {
    [bounds.low.next_down(), bounds.high.next_up()]
}

#[test]
fn what_is_just_outside_is_refused_with_the_reason_and_the_bounds_are_not() {
    let said = |key: &str, value: f64| {
        let setting = format!("{key}={value:e}");
        Scenario::load(&Source::Builtin(SKIN.into()), &[setting]).err().map_or_else(String::new, |error| error.message)
    };
    for (key, bounds) in ranged() {
        for value in just_outside(bounds) {
            let message = said(key, value);
            assert!(message.starts_with(key) && message.ends_with(bounds.requirement), "{key}={value:e}: {message}");
        }
        for value in [bounds.low, bounds.high] {
            let message = said(key, value);
            assert!(!message.contains(bounds.requirement), "{key}={value:e}: {message}");
        }
    }
}

#[test]
fn the_command_refuses_with_exit_code_2() {
    let folder = TestFolder::new();
    let once = keys_of(&LAYER_KEYS[0]).len();
    let keys = ranged();
    let (layers, shaft) = keys.split_at(keys.len() - 4);
    for (key, bounds) in layers[..once].iter().chain(shaft) {
        for value in just_outside(bounds) {
            let set = format!("{key}={value:e}");
            folder.refused(&["run", &format!("builtin:{SKIN}"), "--set", &set], &[key, bounds.requirement]);
        }
    }
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
            assert!((bounds.low..=bounds.high).contains(&value), "{name}: {key} = {value}");
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
