//! Documents, from which `trocar/documents.py` makes Python objects.

use pyo3::prelude::*;
use serde_json::{Value as Json, json};
use trocar_document::{Block, Cell, Document, Table};
use trocar_report::document_text;

use crate::convert;

/// The parts of a document for Python: the answer, the warnings, the tables, the figures, and the text of the command
/// line (with `all`, that of `--all`).
pub(crate) fn contents(document: &Document<'_>, all: bool) -> Json {
    let tables = document.sections.iter().flat_map(|section| {
        section.blocks.iter().filter_map(|block| match block {
            Block::Table(one) => {
                Some(table(one, [section.shown, one.shown].iter().all(|shown| shown.is_on_terminal(false))))
            }
            Block::Text(_) | Block::Command(_) | Block::Figures { .. } => None,
        })
    });
    json!({
        "title": document.title,
        "sentences": document.verdict.sentences,
        "left_out": document.verdict.left_out,
        "warnings": document.warnings,
        "tables": tables.collect::<Vec<_>>(),
        "figures": figures(document),
        "text": document_text(document, all),
    })
}

pub(crate) fn figures(document: &Document<'_>) -> Json {
    document.figures.iter().map(|(name, figure)| (name.to_string(), figure.description())).collect()
}

/// Returns [`contents`] as a dictionary.
pub(crate) fn dictionary<'py>(py: Python<'py>, document: &Document<'_>, all: bool) -> PyResult<Bound<'py, PyAny>> {
    convert::python(py, &contents(document, all))
}

fn table(table: &Table, is_short: bool) -> Json {
    let padded = |cells: &[Cell], of: fn(&Cell) -> Json, rest: Json| -> Json {
        let missing = table.columns.len().saturating_sub(cells.len());
        cells.iter().map(of).chain(std::iter::repeat_n(rest, missing)).collect()
    };
    let values = table.rows.iter().map(|row| padded(&row.cells, value, Json::Null));
    let texts = table.rows.iter().map(|row| padded(&row.cells, |cell| cell.to_string().into(), "".into()));
    json!({
        "key": table.key,
        "caption": table.caption,
        "columns": table.columns.iter().map(|column| &column.key).collect::<Vec<_>>(),
        "labels": table.columns.iter().map(|column| &column.label).collect::<Vec<_>>(),
        "rows": values.collect::<Vec<_>>(),
        "texts": texts.collect::<Vec<_>>(),
        "meanings": table.rows.iter().map(|row| row.meaning).collect::<Vec<_>>(),
        "is_short": is_short,
    })
}

fn value(cell: &Cell) -> Json {
    match cell {
        Cell::Text(text) if text.is_empty() => Json::Null,
        Cell::Text(text) => text.as_str().into(),
        Cell::Flag(flag) => (*flag).into(),
        Cell::Undefined | Cell::Number(_) | Cell::Interval(..) | Cell::PlusMinus(..) => json!(cell.value()),
    }
}
