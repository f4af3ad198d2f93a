//! The first table of a comparison is recomputed row by row from the columns of `trace.csv`.

use std::collections::BTreeMap;
use std::path::Path;

use crate::support::test_folder::TestFolder;
use trocar::compare::SeedStudy;
use trocar::run::{Run, run};
use trocar::scenario::{Scenario, Source};

/// Scenarios with ruptures: recorded and modelled hands, layers, delays, strategies.
const NAMES: [&str; 10] = [
    "paper/classical",
    "paper/augmented",
    "paper/depth-augmented",
    "layers/through-the-skin",
    "layers/skin-augmented",
    "hand/perceiving",
    "hand/reflex-augmented",
    "link/long-delay",
    "strategies/clutch",
    "strategies/cue",
];

/// Returns the columns of a CSV file by name; NaN for cells that are not numbers.
fn columns(path: &Path) -> BTreeMap<String, Vec<f64>> {
    let mut reader = csv::Reader::from_path(path).expect("a table");
    let names: Vec<String> = reader.headers().expect("a header").iter().map(str::to_owned).collect();
    let mut columns = BTreeMap::new();
    for record in reader.records() {
        for (name, cell) in names.iter().zip(record.expect("a row").iter()) {
            columns.entry(name.clone()).or_insert_with(Vec::new).push(cell.parse().unwrap_or(f64::NAN));
        }
    }
    columns
}

/// Computes the rows of the first table for the ruptures at these ticks of a trace, by their keys without the number.
/// `scale` is the position scale of the intended motion.
fn by_definition(
    trace: &BTreeMap<String, Vec<f64>>,
    ticks: &[usize],
    scale: Option<f64>,
) -> Vec<BTreeMap<&'static str, f64>> {
    let of = |name: &str| &trace[name];
    let (slave, hand, force) = (of("slave_position_m"), of("desired_position_m"), of("operator_force_n"));
    let mode = of("mode");
    let mut all = vec![];
    for (index, &at) in ticks.iter().enumerate() {
        let mut rows = BTreeMap::new();
        let advance = |tick: usize| slave[tick] - slave[at];
        let unintended = |tick: usize| scale.map(|scale| advance(tick) - scale * (hand[tick] - hand[at]));
        let (early, horizon) = (at + 300, at + 2000);
        if early < slave.len() {
            rows.insert("slave_travel_m", advance(early));
            rows.extend(unintended(early).map(|metres| ("unintended_travel_m", metres)));
            let peak = force[at..=early].iter().copied().fold(f64::NEG_INFINITY, f64::max);
            let drop = (at..=early).map(|tick| {
                let before = force[at..=tick].iter().copied().fold(f64::NEG_INFINITY, f64::max);
                before - force[tick]
            });
            rows.insert("felt_peak_n", peak);
            rows.insert("felt_drop_n", drop.fold(0.0, f64::max));
        }
        let end = ticks.get(index + 1).copied().unwrap_or(horizon).min(horizon);
        if end < slave.len() {
            rows.insert("horizon_advance_m", advance(end));
            rows.insert("deepest_advance_m", (at..=end).map(advance).fold(0.0, f64::max));
        }
        // The event of this rupture's alarm begins before the next rupture.
        let next = ticks.get(index + 1).copied().unwrap_or(slave.len());
        let begins = (at..next.min(at + 501)).find(|&tick| mode[tick] == 1.0 && mode[tick - 1] == 0.0);
        let returns = begins.and_then(|begins| (begins..slave.len()).find(|&tick| mode[tick] == 0.0));
        if let (Some(begins), Some(returns)) = (begins, returns) {
            rows.insert("return_after_s", 1e-3 * (returns - at) as f64);
            if let Some(released) = (begins..returns).find(|&tick| mode[tick] == 2.0) {
                rows.insert("return_jump_m", slave[returns] - slave[released]);
            }
        }
        all.push(rows);
    }
    all
}

/// Returns the scale of the intended motion, if the hand is not recorded, and the ticks of the ruptures.
fn known_of(name: &str) -> (Option<f64>, Vec<usize>) {
    let run = run(load(name)).expect("a run");
    let ticks = run.metrics.ruptures.iter().map(|rupture| (1e3 * rupture.time_s).round() as usize).collect();
    let is_known = run.metrics.ruptures.iter().any(|rupture| rupture.excess_advance_m.is_some());
    (is_known.then(|| run.scenario.position_scale()), ticks)
}

fn load(name: &str) -> Scenario {
    Scenario::load(&Source::parse(name), &[]).expect("a scenario")
}

#[test]
#[ignore = "more than 5 s of processor time"]
fn the_rows_of_the_first_table_agree_with_the_traces() {
    let folder = TestFolder::new();
    folder.good(&[&["compare"], &NAMES[..]].concat());
    let mut reader = csv::Reader::from_path(folder.path("out/compare/comparison.csv")).expect("a table");
    let header = reader.headers().expect("a header").clone();
    let table: BTreeMap<String, csv::StringRecord> =
        reader.records().map(|row| row.expect("a row")).map(|row| (row[0].to_owned(), row)).collect();
    let mut compared = BTreeMap::<&str, usize>::new();
    for name in NAMES {
        let short = name.rsplit('/').next().expect("a name");
        let column = header.iter().position(|title| title == short).expect("a column");
        let trace = columns(&folder.path(&format!("out/compare/{short}/trace.csv")));
        let (scale, ticks) = known_of(name);
        for (index, rows) in by_definition(&trace, &ticks, scale).iter().enumerate() {
            for (&key, &expected) in rows {
                let value: f64 = table[&format!("rupture_{}_{key}", index + 1)][column].parse().unwrap_or(f64::NAN);
                assert!((value - expected).abs() < 1e-9, "{name}, rupture {}, {key}: {value}, {expected}", index + 1);
                *compared.entry(key).or_default() += 1;
            }
        }
    }
    assert_eq!(compared.len(), 8, "{compared:?}");
    assert!(compared.values().all(|&count| count >= 4), "{compared:?}");
}

#[test]
fn the_medians_over_seeds_agree_with_separate_runs() {
    let scenario = load("layers/through-the-skin");
    let study = SeedStudy::of(std::slice::from_ref(&scenario), 5, || ()).expect("runs");
    let of_seed = |offset: u64| -> Run { run(scenario.with_seed(scenario.seed + offset)).expect("a run") };
    let mut travels: Vec<f64> = (0..5)
        .map(|offset| {
            let run = of_seed(offset);
            let at = (run.metrics.ruptures[0].time_s * 1e3).round() as usize;
            run.trace.slave_position_m[at + 300] - run.trace.slave_position_m[at]
        })
        .collect();
    travels.sort_by(f64::total_cmp);
    let row = study.row("rupture_1_slave_travel_m").expect("a row");
    assert!((row.spreads[0].expect("a spread").median - travels[2]).abs() < 1e-12);
    let ruptures: usize = (0..5).map(|offset| of_seed(offset).metrics.ruptures.len()).sum();
    assert_eq!(study.totals[0].ruptures, ruptures as u64);
}
