use std::borrow::Cow;

use trocar_detect::column_values;
use trocar_document::{DataTable, Values};
use trocar_engine::engine::{COLUMNS, TRUST_COLUMNS, Trace};

pub fn trace_table(trace: &Trace, is_kept: impl Fn(&str) -> bool) -> DataTable<'_> {
    let mut table = DataTable::new("trace").sampled();
    for (name, values) in COLUMNS.into_iter().zip(trace.columns()).filter(|(name, _)| is_kept(name)) {
        table = table.with(name, column_values(values));
    }
    // Its source columns may be missing.
    let needs_trust = TRUST_COLUMNS.iter().any(|column| is_kept(column.name));
    if let Some(trust) = needs_trust.then(|| trace.trust()).flatten() {
        let columns = TRUST_COLUMNS.iter().zip(trust.into_columns());
        for (column, values) in columns.filter(|(column, _)| is_kept(column.name)) {
            table = table.with(column.name, column_values(values));
        }
    }
    if let Some((name, numbers)) = trace.extra_parameter.as_ref().filter(|(name, _)| is_kept(name)) {
        table = table.with(*name, Values::Numbers(Cow::Borrowed(numbers)));
    }
    table
}
