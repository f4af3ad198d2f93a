//! Documents, from which `trocar/documents.py` makes Python objects.

use pyo3::prelude::*;
use pyo3::types::PyDict;
use serde_json::{Value as Json, json};
use trocar_document::{Block, Cell, Document, Table, Values};
use trocar_report::document_text;

use crate::arrays::put;
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

/// The data tables of a document: for each name, columns by their names, as arrays; undefined numbers are NaN.
pub(crate) fn data<'py>(py: Python<'py>, document: &Document<'_>) -> PyResult<Bound<'py, PyDict>> {
    let tables = PyDict::new(py);
    for table in &document.data {
        let columns = PyDict::new(py);
        for column in &table.columns {
            let (name, numbers) = (&*column.name, |numbers: Vec<f64>| put(&columns, &column.name, numbers));
            let optional = |value: Option<f64>| value.unwrap_or(f64::NAN);
            match &column.values {
                Values::Numbers(values) => numbers(values.to_vec())?,
                Values::Optional(values) => numbers(values.iter().copied().map(optional).collect())?,
                Values::Whole(values) => put(&columns, name, values.clone())?,
                Values::OptionalWhole(values) => {
                    numbers(values.iter().map(|value| optional(value.map(|value| value as f64))).collect())?;
                }
                Values::Codes(values) => put(&columns, name, values.to_vec())?,
                Values::Flags(values) => {
                    numbers(values.iter().map(|flag| optional(flag.map(|flag| f64::from(u8::from(flag))))).collect())?;
                }
                Values::Switches(values) => put(&columns, name, values.clone())?,
                Values::Texts(values) => {
                    columns.set_item(name, values.iter().map(|text| text.to_string()).collect::<Vec<_>>())?;
                }
            }
        }
        tables.set_item(&*table.name, columns)?;
    }
    Ok(tables)
}
