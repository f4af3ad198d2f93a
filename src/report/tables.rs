//! Tables for the terminal, and the CSV files.

use std::fmt::Write as _;
use std::io::{self, Write};

use super::Table;
use super::number::{show, significant};
use crate::compare::{Comparison, Fact, Row, Unit};
use crate::detect::{Detection, DetectionReport};
use crate::engine::{COLUMNS, Trace};
use crate::metrics::Outcome;
use crate::run::Run;

/// A run's outcome in words.
fn outcome(run: &Run) -> String {
    match run.metrics.outcome {
        Outcome::Completed => {
            let lasted = run.metrics.ticks as f64 * run.scenario.grid.tick_s();
            format!("{}: completed, {} s in {} ticks", run.scenario.name, significant(lasted), run.metrics.ticks)
        }
        Outcome::Diverged { time_s } => format!("{}: diverged at {time_s} s", run.scenario.name),
    }
}

/// What a run was worth: its outcome, its metrics and its events.
#[must_use]
pub fn run_text(run: &Run) -> String {
    let mut text = outcome(run);
    text.push_str("\n\n");
    let mut table = Table::new(["metric", run.scenario.name.as_str()]);
    for Row { metric, unit, values } in crate::compare::rows(&[&run.metrics], &[]) {
        if let [value] = values.as_slice() {
            table.row([metric, show(*value, unit)]);
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
        .map(|alarm| format!("{:.3} s{}", alarm.time_s, if alarm.matched { "" } else { " (no labelled rupture)" }))
        .collect();
    if alarms.is_empty() { "alarms: none\n".into() } else { format!("alarms: {}\n", alarms.join(", ")) }
}

/// The comparison's table, with what the second scenario changes where there are two.
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
    for Row { metric, unit, values } in table.rows {
        let mut cells = vec![metric];
        cells.extend(values.iter().map(|value| show(*value, unit)));
        if pair {
            cells.push(change(&values, unit));
        }
        lines.row(cells);
    }
    let _ = write!(text, "{lines}");
    text
}

/// From the first to the second value, in per cent; nothing for counts, or where there is nothing to relate to.
fn change(values: &[Option<f64>], unit: Unit) -> String {
    let (&[Some(first), Some(second)], false) = (values, unit == Unit::Count) else { return String::new() };
    let percent = 100.0 * (second - first) / first.abs();
    if first.abs() < 1e-9 || !percent.is_finite() || percent.abs() >= 1e4 {
        return String::new();
    }
    format!("{percent:+.1} %")
}

/// The paper's facts beside ours.
#[must_use]
pub fn facts_text(facts: &[Fact]) -> String {
    let mut table = Table::new(["rupture one, unless it says more", "paper", "asked", "here", ""]).flush_left();
    for fact in facts {
        table.row([fact.what, fact.paper, fact.asked, &fact.ours, if fact.holds { "✓" } else { "✗" }]);
    }
    table.to_string()
}

/// `comparison.csv`: a row per metric, a column per scenario, SI units; empty where undefined.
#[must_use]
pub fn comparison_csv(comparison: &Comparison) -> String {
    let table = comparison.table();
    let mut text = format!("metric,unit,{}\n", table.scenarios.join(","));
    for row in table.rows {
        let values: Vec<String> = row.values.iter().map(|value| value.map_or(String::new(), shortest)).collect();
        let _ = writeln!(text, "{},{},{}", quoted(&row.metric), si(row.unit), values.join(","));
    }
    text
}

pub(super) fn quoted(text: &str) -> String {
    if text.contains([',', '"']) { format!("\"{}\"", text.replace('"', "\"\"")) } else { text.to_owned() }
}

pub(super) fn si(unit: Unit) -> &'static str {
    match unit {
        Unit::Metre => "m",
        Unit::MetrePerSecond => "m/s",
        Unit::Second => "s",
        Unit::Newton => "N",
        Unit::NewtonPerSecond => "N/s",
        Unit::Joule => "J",
        Unit::Share | Unit::Count => "1",
    }
}

pub(super) fn shortest(value: f64) -> String {
    ryu::Buffer::new().format(value).to_owned()
}

/// `trace.csv`: the columns of [`COLUMNS`], then what the estimator estimates besides, floats in the shortest form that reads back the same.
///
/// # Errors
/// Those of the writer.
pub fn write_trace_csv(trace: &Trace, out: &mut dyn Write) -> io::Result<()> {
    let further = trace.further.as_ref();
    writeln!(out, "{}{}", COLUMNS.join(","), further.map_or(String::new(), |(name, _)| format!(",{name}")))?;
    let numbers = trace.numbers();
    let mut buffer = ryu::Buffer::new();
    let mut line = String::with_capacity(400);
    for (row, mode) in trace.mode.iter().enumerate() {
        line.clear();
        for column in &numbers {
            line.push_str(buffer.format(column[row]));
            line.push(',');
        }
        match further {
            None => writeln!(out, "{line}{mode}")?,
            Some((_, column)) => writeln!(out, "{line}{mode},{}", buffer.format(column[row]))?,
        }
    }
    Ok(())
}

/// What a detection found, in words and a table.
#[must_use]
pub fn detection_text(name: &str, report: &DetectionReport) -> String {
    let mut text = format!(
        "{name}: {} samples over {} s, {} alarm{}\n\n",
        report.samples,
        significant(report.duration_s),
        report.alarms.len(),
        if report.alarms.len() == 1 { "" } else { "s" }
    );
    if !report.alarms.is_empty() {
        let mut table = Table::new(["alarm", "time", "position", "force", "residual", "delay"]);
        for (index, alarm) in report.alarms.iter().enumerate() {
            table.row([
                format!("{}", index + 1),
                format!("{:.4} s", alarm.time_s),
                show(Some(alarm.position_m), Unit::Metre),
                show(Some(alarm.force_n), Unit::Newton),
                show(Some(alarm.residual_n), Unit::Newton),
                show(alarm.delay_s, Unit::Second),
            ]);
        }
        let _ = writeln!(text, "{table}");
    }
    if !report.touched {
        text.push_str(
            "the needle never went below the contact: give it with --contact-m, or turn the position's sign\n\n",
        );
    }
    let mut table = Table::new(["residual", "value"]);
    let newton = |value| show(Some(value), Unit::Newton);
    table.row(["mean".to_owned(), newton(report.residual.mean_n)]);
    table.row(["standard deviation".to_owned(), newton(report.residual.std_n)]);
    table.row(["robust standard deviation".to_owned(), newton(report.residual.robust_std_n)]);
    table.row(["mean magnitude".to_owned(), newton(report.residual.mean_absolute_n)]);
    table.row(["greatest magnitude".to_owned(), newton(report.residual.greatest_absolute_n)]);
    let _ = write!(text, "{table}");
    if let (Some(missed), Some(false_alarms)) = (report.missed_ruptures, report.false_alarms) {
        let labels = report.labelled_ruptures_s.len();
        let _ = writeln!(text, "\n{labels} labelled ruptures: {missed} missed, {false_alarms} false alarms");
    }
    text
}

/// `detection.csv`: the samples with their estimates and decisions.
///
/// # Errors
/// Those of the writer.
pub fn write_detection_csv(detection: &Detection, out: &mut dyn Write) -> io::Result<()> {
    let columns: [(&str, &[f64]); 9] = [
        ("time_s", &detection.time_s),
        ("position_m", &detection.position_m),
        ("velocity_m_per_s", &detection.velocity_m_per_s),
        ("measured_force_n", &detection.measured_force_n),
        ("stiffness_n_per_m", &detection.stiffness_n_per_m),
        ("damping_n_s_per_m", &detection.damping_n_s_per_m),
        ("residual_n", &detection.residual_n),
        ("distance", &detection.distance),
        ("decision", &detection.decision),
    ];
    let mut columns = columns.to_vec();
    columns.extend(detection.further.iter().map(|(name, column)| (*name, column.as_slice())));
    writeln!(out, "{}", columns.iter().map(|(name, _)| *name).collect::<Vec<_>>().join(","))?;
    let mut buffer = ryu::Buffer::new();
    for row in 0..detection.time_s.len() {
        for (index, (_, column)) in columns.iter().enumerate() {
            let separator = if index == 0 { "" } else { "," };
            write!(out, "{separator}{}", buffer.format(column[row]))?;
        }
        writeln!(out)?;
    }
    Ok(())
}
