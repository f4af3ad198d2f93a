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

#[test]
fn former_names_of_metrics_are_accepted_with_a_note() {
    let folder = TestFolder::new();
    let file = |metrics: &str| {
        format!(
            "base = \"builtin:paper/augmented.toml\"\nmetrics = [{metrics}]\nset.simulation.duration_s = 6.0\naxes.scaling.force = [0.5, 1.0]\n"
        )
    };
    folder.file("old.toml", file("\"most_slave_overshoot_m\", \"tracking_rmse_m\""));
    let old = folder.command(&["sweep", "old.toml", "--out", "out"]).assert().success();
    let noted = String::from_utf8_lossy(&old.get_output().stderr).into_owned();
    assert!(noted.contains("note: the metric most_slave_overshoot_m is called max_slave_overshoot_m now"), "{noted}");
    let rows = folder.text("out/old/cases.csv");
    assert!(rows.starts_with("case,scaling.force,seed,outcome,max_slave_overshoot_m,tracking_rmse_m\n"), "{rows}");
    folder.file("twice.toml", file("\"most_slave_overshoot_m\", \"max_slave_overshoot_m\""));
    folder.refused(&["sweep", "twice.toml"], &["max_slave_overshoot_m", "twice"]);
    for metric in declarations().filter_map(|metric| metric.former_name) {
        assert!(Column::named(metric).is_some_and(|column| column.name != metric), "{metric}");
    }
}
