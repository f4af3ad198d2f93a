//! A comparison as text and as CSV.

use std::fmt::Write as _;

use super::Table;
use super::finding::finding;
use super::tables::outcome;
use super::wrap::wrapped;
use trocar_document::shortest;
use trocar_document::show;
use trocar_metrics::{Outcome, Scope, Unit};
use trocar_studies::compare::{Comparison, Fact, Row};

/// Number of ruptures in the short table.
const SHOWN_RUPTURES: usize = 2;

/// A value below this share of another one is vanishing: the relative change between them has no meaning.
const VANISHING_SHARE: f64 = 0.01;

/// Returns the short table of a comparison and, below it, what the comparison shows.
#[must_use]
pub fn comparison_text(comparison: &Comparison) -> String {
    let table = table(comparison, is_main);
    let ruptures = comparison.runs.iter().map(|run| run.metrics.ruptures.len()).max().unwrap_or(0);
    let mut text = format!("{}{table}", incomplete(comparison));
    if ruptures > SHOWN_RUPTURES {
        let _ = writeln!(text, "The first {SHOWN_RUPTURES} of {ruptures} ruptures; --all shows the others.");
    }
    format!("{text}\n{}", finding_text(comparison))
}

/// Returns whether a row is in the short table.
pub(super) fn is_main(row: &Row) -> bool {
    let is_later = row.declaration.scope == Scope::Rupture && row.number > SHOWN_RUPTURES;
    row.declaration.shown.is_main() && !is_later
}

/// Returns the table of all metrics. A pair has a column with the change from the first scenario to the second.
#[must_use]
pub fn all_metrics_text(comparison: &Comparison) -> String {
    format!("{}{}", incomplete(comparison), table(comparison, |_| true))
}

/// Returns what the comparison shows, as one sentence.
#[must_use]
pub fn finding_text(comparison: &Comparison) -> String {
    wrapped(&format!("{}\n", finding(&comparison.runs.iter().collect::<Vec<_>>())), 0)
}

/// Returns a line for each run that ended early.
fn incomplete(comparison: &Comparison) -> String {
    let runs = comparison.runs.iter().filter(|run| run.metrics.outcome != Outcome::Completed);
    runs.map(|run| format!("{}\n", outcome(run))).collect()
}

fn table(comparison: &Comparison, is_shown: impl Fn(&Row) -> bool) -> Table {
    let numbers = comparison.table();
    let is_pair = numbers.scenarios.len() == 2;
    let mut heading = vec!["metric".to_owned()];
    heading.extend(numbers.scenarios);
    if is_pair {
        heading.push("change".into());
    }
    let mut table = Table::new(heading);
    for row in numbers.rows.iter().filter(|row| is_shown(row)) {
        table.row(row_cells(row));
    }
    table
}

/// Returns a row of the comparison's table: the metric, its values, and for a pair the change.
#[must_use]
pub fn row_cells(row: &Row) -> Vec<String> {
    let mut cells = vec![row.label.clone()];
    cells.extend(row.values.iter().map(|value| show(*value, row.unit)));
    if let [first, second] = row.values[..] {
        cells.push(change(row, first, second));
    }
    cells
}

/// Returns the relative change of a metric. It is empty where it has no meaning: for counts, metrics whose sign varies,
/// undefined values, and a first value of 0 or of almost 0 against the second.
pub(super) fn change(row: &Row, first: Option<f64>, second: Option<f64>) -> String {
    let (Some(first), Some(second)) = (first, second) else { return String::new() };
    let has_meaning = row.unit != Unit::Count && !row.declaration.is_signed && second >= 0.0;
    if !has_meaning || first < 1e-9 || first < VANISHING_SHARE * second {
        return String::new();
    }
    let percent = 100.0 * (second / first - 1.0);
    if second == 0.0 {
        "-100 %".into()
    } else if percent < -99.9 {
        "below -99.9 %".into()
    } else if percent.abs() < 0.05 {
        "0 %".into()
    } else {
        format!("{percent:+.1} %")
    }
}

/// Returns the paper's statements with the results of this comparison, as text.
#[must_use]
pub fn facts_text(facts: &[Fact]) -> String {
    facts_table(facts).to_string()
}

/// Returns the paper's statements with the results of this comparison.
pub(super) fn facts_table(facts: &[Fact]) -> Table {
    let mut table = Table::new(["statement (rupture 1 unless stated)", "paper", "required", "result", ""]).flush_left();
    for fact in facts {
        table.row([fact.what, fact.paper, fact.asked, &fact.ours, if fact.holds { "✓" } else { "✗" }]);
    }
    table
}

/// Returns `comparison.csv`: a row per metric, a column per scenario, in SI units. An undefined value is an empty cell.
#[must_use]
pub fn comparison_csv(comparison: &Comparison) -> String {
    let table = comparison.table();
    let mut text = format!("metric,unit,{}\n", table.scenarios.join(","));
    for row in table.rows {
        let values: Vec<String> = row.values.iter().map(|value| value.map_or(String::new(), shortest)).collect();
        let _ = writeln!(text, "{},{},{}", row.metric, row.unit.si(), values.join(","));
    }
    text
}
