//! Tables for the terminal, and CSV files.

use std::fmt::Write as _;
use std::io::{self, Write};

use super::Table;
use super::number::{show, significant};
use trocar_sim::compare::{Comparison, Fact, Row};
use trocar_sim::engine::{COLUMNS, ColumnValues, Trace};
use trocar_sim::metrics::{Outcome, Unit};
use trocar_sim::run::Run;

/// Returns a run's outcome as text.
pub(super) fn outcome(run: &Run) -> String {
    match run.metrics.outcome {
        Outcome::Completed => {
            let duration_s = run.metrics.ticks as f64 * run.scenario.grid.tick_s();
            format!("{}: completed, {} s in {} ticks", run.scenario.name, significant(duration_s), run.metrics.ticks)
        }
        Outcome::Diverged { time_s } => format!("{}: diverged at {time_s} s", run.scenario.name),
    }
}

/// Returns a run's outcome, metrics and alarms as text.
#[must_use]
pub fn run_text(run: &Run) -> String {
    let mut text = outcome(run);
    text.push_str("\n\n");
    let mut table = Table::new(["metric", run.scenario.name.as_str()]);
    for Row { label, unit, values, .. } in trocar_sim::compare::rows(&[&run.metrics], &[]) {
        if let [value] = values.as_slice() {
            table.row([label, show(*value, unit)]);
        }
    }
    let _ = write!(text, "{table}{}", alarms_line(run));
    text
}

fn alarms_line(run: &Run) -> String {
    let alarms: Vec<String> = run
        .metrics
        .alarms
        .iter()
        .map(|alarm| format!("{:.3} s{}", alarm.time_s, if alarm.matched { "" } else { " (false alarm)" }))
        .collect();
    if alarms.is_empty() { "alarms: none\n".into() } else { format!("alarms: {}\n", alarms.join(", ")) }
}

/// Returns the comparison's table. A pair has a column with the change from the first scenario to the second.
#[must_use]
pub fn comparison_text(comparison: &Comparison) -> String {
    let mut text = String::new();
    for run in &comparison.runs {
        if run.metrics.outcome != Outcome::Completed {
            let _ = writeln!(text, "{}", outcome(run));
        }
    }
    let table = comparison.table();
    let pair = table.scenarios.len() == 2;
    let mut heading = vec!["metric".to_owned()];
    heading.extend(table.scenarios);
    if pair {
        heading.push("change".into());
    }
    let mut lines = Table::new(heading);
    for row in &table.rows {
        lines.row(row_cells(row));
    }
    let _ = write!(text, "{lines}");
    text
}

/// Returns a row of the comparison's table: the metric, its values, and for a pair the change.
#[must_use]
pub fn row_cells(row: &Row) -> Vec<String> {
    let mut cells = vec![row.label.clone()];
    cells.extend(row.values.iter().map(|value| show(*value, row.unit)));
    if row.values.len() == 2 {
        cells.push(change(&row.values, row.unit));
    }
    cells
}

/// Returns the change from the first to the second value in per cent; empty for counts, undefined values and a first value
/// of about 0.
pub(super) fn change(values: &[Option<f64>], unit: Unit) -> String {
    let (&[Some(first), Some(second)], false) = (values, unit == Unit::Count) else { return String::new() };
    let percent = 100.0 * (second - first) / first.abs();
    if first.abs() < 1e-9 || !percent.is_finite() || percent.abs() >= 1e4 {
        return String::new();
    }
    format!("{percent:+.1} %")
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

/// Returns a CSV cell, quoted if necessary.
pub(super) fn quoted(text: &str) -> String {
    if text.contains([',', '"']) { format!("\"{}\"", text.replace('"', "\"\"")) } else { text.to_owned() }
}

/// Returns the shortest decimal form that reads back to the same value.
pub(super) fn shortest(value: f64) -> String {
    ryu::Buffer::new().format(value).to_owned()
}

/// Writes `trace.csv`: the columns of [`COLUMNS`], then the estimator's extra parameter, if any. Floats have the shortest form
/// that reads back to the same value.
///
/// # Errors
/// Returns the errors of the writer.
pub fn write_trace_csv(trace: &Trace, out: &mut dyn Write) -> io::Result<()> {
    let extra = trace.extra_parameter.as_ref();
    writeln!(out, "{}{}", COLUMNS.join(","), extra.map_or(String::new(), |(name, _)| format!(",{name}")))?;
    let extra = extra.map(|(_, column)| ColumnValues::Numbers(column.as_slice()));
    let columns: Vec<_> = trace.columns().into_iter().chain(extra).collect();
    let mut buffer = ryu::Buffer::new();
    let mut line = String::with_capacity(400);
    for row in 0..trace.len() {
        line.clear();
        for column in &columns {
            match column {
                ColumnValues::Numbers(numbers) => line.push_str(buffer.format(numbers[row])),
                ColumnValues::Codes(codes) => line.push_str(&codes[row].to_string()),
            }
            line.push(',');
        }
        line.pop();
        line.push('\n');
        out.write_all(line.as_bytes())?;
    }
    Ok(())
}
