//! The files of a trace: a row per tick.

use std::io::{self, Write};

use super::columns::{Column, ColumnFormat, csv};
use trocar_engine::engine::{COLUMNS, ColumnValues, TRUST_COLUMNS, Trace, TrustColumns};

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
