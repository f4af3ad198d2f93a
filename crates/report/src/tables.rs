//! The tables of a run, and the CSV file of its trace.

use std::fmt::Write as _;
use std::io::{self, Write};

use super::Table;
use super::columns::{Column, ColumnFormat, csv};
use super::wrap::wrapped;
use trocar_document::{show, significant};
use trocar_engine::engine::{COLUMNS, ColumnValues, TRUST_COLUMNS, Trace, TrustColumns};
use trocar_metrics::{Outcome, RuptureMetrics, Unit};
use trocar_studies::compare::Row;
use trocar_studies::run::Run;

/// Returns a run's outcome as text.
pub(super) fn outcome(run: &Run) -> String {
    let duration_s = run.metrics.ticks as f64 * run.scenario.grid.tick_s();
    match run.metrics.outcome {
        Outcome::Completed => {
            format!("{}: completed, {} s in {} ticks", run.scenario.name, significant(duration_s), run.metrics.ticks)
        }
        Outcome::Oscillating { frequency_hz, swing_m } => format!(
            "{}: oscillating, by {} at {} Hz without decay",
            run.scenario.name,
            show(Some(swing_m), Unit::Metre),
            significant(frequency_hz)
        ),
        Outcome::Diverged { time_s } => format!("{}: diverged at {time_s} s", run.scenario.name),
    }
}

/// Returns a run's outcome, metrics and alarms as text.
#[must_use]
pub fn run_text(run: &Run) -> String {
    let mut text = outcome(run);
    text.push_str("\n\n");
    let mut table = Table::new(["metric", run.scenario.name.as_str()]);
    for Row { label, unit, values, .. } in trocar_studies::compare::rows(&[&run.metrics], &[]) {
        if let [value] = values.as_slice() {
            table.row([label, show(*value, unit)]);
        }
    }
    let _ = write!(text, "{table}{}{}", wrapped(&ruptures_line(run), 2), wrapped(&alarms_line(run), 2));
    text
}

/// Returns the ruptures of named layers; nothing for other tissues.
fn ruptures_line(run: &Run) -> String {
    let of_layer = |rupture: &RuptureMetrics| Some(format!("{:.3} s ({})", rupture.time_s, rupture.layer.as_deref()?));
    let ruptures: Vec<String> = run.metrics.ruptures.iter().filter_map(of_layer).collect();
    if ruptures.is_empty() { String::new() } else { format!("ruptures: {}\n", ruptures.join(", ")) }
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

/// Returns a CSV cell, quoted if necessary.
pub(super) fn quoted(text: &str) -> String {
    if text.contains([',', '"']) { format!("\"{}\"", text.replace('"', "\"\"")) } else { text.to_owned() }
}

/// The columns of a trace: those of [`COLUMNS`], then the trust in the estimate and the estimator's extra parameter, if any.
fn trace_columns<'a>(trace: &'a Trace, trust: Option<&'a TrustColumns>) -> Vec<Column<'a>> {
    let extra = trace.extra_parameter.as_ref();
    let extra = extra.map(|(name, column)| (*name, ColumnValues::Numbers(column.as_slice())));
    let trust = trust.into_iter().flat_map(|trust| TRUST_COLUMNS.iter().map(|column| column.name).zip(trust.columns()));
    COLUMNS.into_iter().zip(trace.columns()).chain(trust).chain(extra).collect()
}

/// Writes `trace.csv`: the columns of [`COLUMNS`], then the trust in the estimate and the estimator's extra parameter, if any. Floats have the shortest form
/// that reads back to the same value.
///
/// # Errors
/// Returns the errors of the writer.
pub fn write_trace_csv(trace: &Trace, out: &mut dyn Write) -> io::Result<()> {
    csv(&trace_columns(trace, trace.trust().as_ref()), out)
}

/// Writes the columns of [`write_trace_csv`] in another format.
///
/// # Errors
/// Returns the errors of the writer.
pub fn write_trace(trace: &Trace, format: ColumnFormat, out: &mut (dyn Write + Send)) -> io::Result<()> {
    format.write("run", &trace_columns(trace, trace.trust().as_ref()), out)
}

/// Writes some columns of [`write_trace_csv`], by their names and in the order of the trace. `topic` names their rows in a log.
///
/// # Errors
/// Returns the errors of the writer.
pub fn write_trace_columns(
    trace: &Trace,
    topic: &str,
    names: &[&str],
    format: ColumnFormat,
    out: &mut (dyn Write + Send),
) -> io::Result<()> {
    let needs_trust = TRUST_COLUMNS.iter().any(|column| names.contains(&column.name));
    let trust = needs_trust.then(|| trace.trust()).flatten();
    let mut columns = trace_columns(trace, trust.as_ref());
    columns.retain(|(name, _)| names.contains(name));
    format.write(topic, &columns, out)
}
