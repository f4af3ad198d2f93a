//! The catalogue of metrics: each metric is declared once, and all outputs use the declaration.

use std::collections::BTreeSet;

use trocar::engine::{COLUMNS, TRACE_COLUMNS};
use trocar::reference::{declarations, metrics_markdown, trace_columns_markdown};
use trocar::sweep::{Column, sweep_schema};

use crate::support::test_folder::TestFolder;

#[test]
fn every_surface_has_every_metric() {
    let (table, schema) = (metrics_markdown(), sweep_schema().to_string());
    let folder = TestFolder::new();
    let help = folder.good(&["sweep", "--help"]);
    let mut keys = BTreeSet::new();
    for metric in declarations() {
        let key = metric.key(1);
        assert!(table.contains(&format!("| `{key}` | ")) && table.contains(metric.meaning), "{key}");
        assert!(keys.insert(key), "{} is there twice", metric.name);
    }
    for column in Column::names() {
        assert!(help.contains(&column) && schema.contains(&format!("{column:?}")), "{column}");
    }
    let columns = trace_columns_markdown();
    assert!(TRACE_COLUMNS.iter().zip(COLUMNS).all(|(column, name)| column.name == name));
    assert!(COLUMNS.iter().all(|name| columns.contains(&format!("| `{name}` | "))));
}
