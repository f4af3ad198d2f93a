//! The table of a study over seeds, and its CSV file.

use std::fmt::Write as _;

use super::Table;
use super::wrap::wrapped;
use trocar_document::shortest;
use trocar_document::{readable, significant};
use trocar_metrics::Unit;
use trocar_studies::compare::{SeedStudy, Spread};

/// The metrics in the terminal's table. The files hold all metrics.
const SHOWN: [&str; 8] = [
    "detection_delay_s",
    "excess_advance_m",
    "horizon_advance_m",
    "depth_at_return_m",
    "noticed",
    "missed_ruptures",
    "false_alarms",
    "tissue_energy_j",
];

/// Returns the main metrics. A metric has a line for each scenario, with the median and the central 95 % interval over the seeds,
/// and for a pair a line with the ratio of the second scenario to the first, seed by seed.
#[must_use]
pub(super) fn seeds_table(study: &SeedStudy) -> Table {
    let heading = [&format!("over {} seeds", study.seeds), "median", "2.5 %", "97.5 %", "seeds"];
    let mut table = Table::new(heading);
    let is_pair = study.scenarios.len() == 2;
    for row in study.rows.iter().filter(|row| SHOWN.contains(&row.name)) {
        let (factor, unit) = readable(row.unit);
        let unit = if unit.is_empty() { String::new() } else { format!(" ({})", unit.trim_start()) };
        table.row([format!("{}{unit}", row.label)]);
        let is_whole = |value: f64| row.unit == Unit::Count && value.fract() == 0.0;
        let number = |value: f64| if is_whole(value) { format!("{value}") } else { significant(factor * value) };
        for (name, spread) in study.scenarios.iter().zip(&row.spreads) {
            table.row(spread_cells(name, spread.as_ref(), number));
        }
        if let (true, [_, Some(ratio)]) = (is_pair, &row.ratios[..]) {
            table.row(spread_cells("second / first", Some(ratio), significant));
        }
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
        let note = "No metric depends on the seed: the scenarios have no random noise, tremor or reaction time.\n";
        format!("{table}{}", wrapped(note, 0))
    }
}

/// Returns a line of the table: the median, the ends of the interval, and the number of seeds with a value.
fn spread_cells(name: &str, spread: Option<&Spread>, number: impl Fn(f64) -> String) -> [String; 5] {
    let name = format!("  {name}");
    let Some(spread) = spread else { return [name, "—".into(), "—".into(), "—".into(), "0".into()] };
    let [median, low, high] = [spread.median, spread.low, spread.high].map(number);
    [name, median, low, high, spread.defined.to_string()]
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
