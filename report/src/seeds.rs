//! The table of a study over seeds, and its CSV file.

use std::fmt::Write as _;

use super::Table;
use super::number::{readable, significant};
use super::tables::shortest;
use trocar_sim::compare::{SeedStudy, Spread};
use trocar_sim::metrics::Unit;

/// The metrics in the terminal's table. The files hold all metrics.
const SHOWN: [&str; 7] = [
    "slave_overshoot_m",
    "slave_travel_m",
    "felt_contrast",
    "detection_delay_s",
    "missed_ruptures",
    "false_alarms",
    "tissue_energy_j",
];

/// Returns the main metrics: for each scenario the median and the central 95 % interval over the seeds, and for a pair the
/// ratio of the second scenario to the first, seed by seed.
#[must_use]
pub(super) fn seeds_table(study: &SeedStudy) -> Table {
    let mut heading = vec![format!("{} seeds: median [2.5 %, 97.5 %]", study.seeds)];
    heading.extend(study.scenarios.iter().cloned());
    let is_pair = study.scenarios.len() == 2;
    if is_pair {
        heading.push("second / first".into());
    }
    let mut table = Table::new(heading);
    for row in study.rows.iter().filter(|row| SHOWN.contains(&row.name)) {
        let mut cells = vec![row.label.clone()];
        cells.extend(row.spreads.iter().map(|spread| of_unit(spread.as_ref(), row.unit, study.seeds)));
        if is_pair {
            cells.extend(row.ratios.iter().skip(1).map(|ratio| ratio.as_ref().map_or(String::new(), of_ratio)));
        }
        table.row(cells);
    }
    table
}

/// Returns the table, with a note if no metric depends on the seed.
#[must_use]
pub fn seeds_text(study: &SeedStudy) -> String {
    let table = seeds_table(study);
    let varies = |spread: &Spread| spread.low < spread.high;
    if study.rows.iter().flat_map(|row| &row.spreads).flatten().any(varies) {
        table.to_string()
    } else {
        format!("{table}No metric depends on the seed: the scenarios have no random noise, tremor or reaction time.\n")
    }
}

/// Returns the median and the interval in one unit, and the number of seeds with a value unless every seed has one.
fn of_unit(spread: Option<&Spread>, unit: Unit, seeds: u64) -> String {
    let Some(spread) = spread else { return "—".into() };
    let (factor, name) = readable(unit);
    let is_whole = |value: f64| unit == Unit::Count && value.fract() == 0.0;
    let number = |value: f64| if is_whole(value) { format!("{value}") } else { significant(factor * value) };
    let counted = if spread.defined < seeds { format!(" (in {})", spread.defined) } else { String::new() };
    format!("{} [{}, {}]{name}{counted}", number(spread.median), number(spread.low), number(spread.high))
}

fn of_ratio(ratio: &Spread) -> String {
    format!("{} [{}, {}]", significant(ratio.median), significant(ratio.low), significant(ratio.high))
}

/// Returns `seeds.csv`: a row per metric and scenario, in SI units. A metric that no seed defines has empty cells.
#[must_use]
pub fn seeds_csv(study: &SeedStudy) -> String {
    let mut text = "metric,unit,scenario,defined,median,low_2.5,high_97.5,median_low,median_high".to_owned();
    text.push_str(",ratio_median,ratio_low_2.5,ratio_high_97.5\n");
    for row in &study.rows {
        for (index, scenario) in study.scenarios.iter().enumerate() {
            let numbers = |spread: Option<Spread>, of: &dyn Fn(&Spread) -> Vec<f64>, count: usize| match spread {
                Some(spread) => of(&spread).into_iter().map(shortest).collect::<Vec<_>>().join(","),
                None => ",".repeat(count - 1),
            };
            let defined = row.spreads[index].map_or(0, |spread| spread.defined);
            let spread =
                numbers(row.spreads[index], &|s| vec![s.median, s.low, s.high, s.median_low, s.median_high], 5);
            let ratio = numbers(row.ratios[index], &|s| vec![s.median, s.low, s.high], 3);
            let _ = writeln!(text, "{},{},{scenario},{defined},{spread},{ratio}", row.metric, row.unit.si());
        }
    }
    text
}
