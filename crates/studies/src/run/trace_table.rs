//! The columns of a trace.

use std::borrow::Cow;

use trocar_document::{DataTable, Values};
use trocar_engine::engine::{COLUMNS, ColumnValues, TRUST_COLUMNS, Trace};

/// The columns of a trace whose names are kept, with a row per tick: those of [`COLUMNS`], then the trust in the estimate and the
/// estimator's extra parameter, if any.
#[must_use]
pub fn trace_table(trace: &Trace, is_kept: impl Fn(&str) -> bool) -> DataTable<'_> {
    let mut table = DataTable::new("trace").topic("run").sampled();
    for (name, values) in COLUMNS.into_iter().zip(trace.columns()).filter(|(name, _)| is_kept(name)) {
        let values = match values {
            ColumnValues::Numbers(numbers) => Values::Numbers(Cow::Borrowed(numbers)),
            ColumnValues::Codes(codes) => Values::Codes(Cow::Borrowed(codes)),
        };
        table = table.with(name, values);
    }
    // The trust takes time and is computed from columns that a part of a trace may not have.
    let needs_trust = TRUST_COLUMNS.iter().any(|column| is_kept(column.name));
    if let Some(trust) = needs_trust.then(|| trace.trust()).flatten() {
        for (column, values) in TRUST_COLUMNS.iter().zip(trust.columns()).filter(|(column, _)| is_kept(column.name)) {
            let values = match values {
                ColumnValues::Numbers(numbers) => Values::Numbers(Cow::Owned(numbers.to_vec())),
                ColumnValues::Codes(codes) => Values::Codes(Cow::Owned(codes.to_vec())),
            };
            table = table.with(column.name, values);
        }
    }
    if let Some((name, numbers)) = trace.extra_parameter.as_ref().filter(|(name, _)| is_kept(name)) {
        table = table.with(*name, Values::Numbers(Cow::Borrowed(numbers)));
    }
    table
}
