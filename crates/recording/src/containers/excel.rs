//! Spreadsheets: a signal `Sheet1!B` per column with numbers, which its header, if any, also names.
//!
//! The numbers begin below the last of the first rows that contain only texts. That row contains the names of the
//! columns. If it contains a known unit, it is the row of units, and the names are in the row above.

use std::collections::BTreeMap;
use std::io::{Cursor, Read};

use calamine::{Data, DataRef, DataType, Reader, Xls, Xlsx};

use super::{Array, Container, Fault, Format};
use crate::Limits;
use crate::error::{Problem, Row, excerpt};
use crate::units;

/// Maximum number of rows searched for the names of the columns.
const HEAD_ROWS: u32 = 200;

const SECONDS_PER_DAY: f64 = 86_400.0;

enum Cell {
    Number(f64),
    /// A time, in s.
    Time(f64),
    Text(Box<str>),
}

type Sheet = BTreeMap<u32, BTreeMap<u32, Cell>>;

struct Stored {
    first_row: u32,
    cells: BTreeMap<u32, Cell>,
}

pub(super) struct Excel {
    arrays: Vec<Array>,
    stored: Vec<Stored>,
}

fn damaged(error: impl std::fmt::Display) -> Problem {
    Format::Excel.damaged(error)
}

impl Excel {
    pub(super) fn open(bytes: Vec<u8>, limits: &Limits) -> Result<Self, Problem> {
        let mut found = Self { arrays: vec![], stored: vec![] };
        if bytes.starts_with(b"PK") {
            check_archive(&bytes, limits)?;
            let mut book = Xlsx::new(Cursor::new(bytes)).map_err(damaged)?;
            for name in book.sheet_names() {
                let mut sheet = Sheet::new();
                let mut cells = book.worksheet_cells_reader(&name).map_err(damaged)?;
                while let Some(cell) = cells.next_cell().map_err(damaged)? {
                    let text = match cell.get_value() {
                        DataRef::SharedString(text) => Some(*text),
                        DataRef::String(text) => Some(text.as_str()),
                        _ => None,
                    };
                    insert(&mut sheet, cell.get_position(), cell.get_value(), text);
                }
                found.sheet(&name, sheet);
            }
        } else {
            let mut book = Xls::new(Cursor::new(bytes)).map_err(damaged)?;
            for name in book.sheet_names() {
                let range = book.worksheet_range(&name).map_err(damaged)?;
                let (top, left) = range.start().unwrap_or_default();
                let mut sheet = Sheet::new();
                for (row, column, value) in range.used_cells() {
                    let text = if let Data::String(text) = value { Some(text.as_str()) } else { None };
                    insert(&mut sheet, (top + row as u32, left + column as u32), value, text);
                }
                found.sheet(&name, sheet);
            }
        }
        if super::vectors(&found.arrays).is_empty() { Err(Problem::no_signal(Format::Excel, &[])) } else { Ok(found) }
    }

    fn sheet(&mut self, name: &str, mut sheet: Sheet) {
        let texts = |row: u32| -> Vec<&str> {
            let texts = sheet.values().filter_map(|cells| cells.get(&row)).map(|cell| match cell {
                Cell::Text(text) => Some(&**text),
                _ => None,
            });
            texts.collect::<Option<Vec<_>>>().unwrap_or_default()
        };
        let last_texts = |below: u32| (0..below).rev().find(|row| !texts(*row).is_empty());
        let mut header = last_texts(HEAD_ROWS);
        let first_row = header.map_or(0, |row| row + 1);
        let mut units = None;
        if header.is_some_and(|row| texts(row).into_iter().any(units::is_known)) {
            units = header;
            header = header.and_then(last_texts);
        }
        for (column, cells) in &mut sheet {
            let text = |row: Option<u32>| match cells.get(&row?) {
                Some(Cell::Text(text)) => Some(text.trim().to_owned()),
                _ => None,
            };
            let (label, unit) = (text(header), text(units));
            let unit = unit.map(|unit| unit.trim_matches(['[', ']', '(', ')']).to_owned());
            let mut cells = cells.split_off(&first_row);
            let is_number = |cell: &Cell| !matches!(cell, Cell::Text(_));
            if !cells.values().any(is_number) {
                continue;
            }
            let has_times = cells.values().any(|cell| matches!(cell, Cell::Time(_)));
            let len = cells.last_entry().map_or(0, |last| last.key() - first_row + 1) as usize;
            let aliases = label.iter().flat_map(|label| [label.clone(), format!("{name}!{label}")]).collect();
            let unit = unit.or_else(|| has_times.then(|| "s".to_owned()));
            let array = Array::new(format!("{name}!{}", letters(*column)), vec![len]);
            self.arrays.push(Array { aliases, label, unit, ..array });
            self.stored.push(Stored { first_row, cells });
        }
    }
}

fn insert(sheet: &mut Sheet, (row, column): (u32, u32), value: &impl DataType, text: Option<&str>) {
    let cell = match (text, value.as_f64()) {
        (Some(text), _) if text.trim().is_empty() => return,
        (Some(text), _) => Cell::Text(text.into()),
        (None, _) if value.is_empty() => return,
        (None, Some(days)) if value.is_datetime() => Cell::Time(days * SECONDS_PER_DAY),
        (None, Some(number)) => Cell::Number(number),
        (None, None) => Cell::Text(value.as_string().unwrap_or_else(|| "an error".into()).into()),
    };
    sheet.entry(column).or_default().insert(row, cell);
}

/// The letters of a column, counted from 0: A to Z, AA, …
fn letters(column: u32) -> String {
    let last = char::from(b'A' + (column % 26) as u8);
    if column < 26 { last.to_string() } else { format!("{}{last}", letters(column / 26 - 1)) }
}

/// Checks that the decompressed content of a file is within the limit. It decompresses the file, because the stated
/// sizes can be wrong.
fn check_archive(bytes: &[u8], limits: &Limits) -> Result<(), Problem> {
    let mut archive = zip::ZipArchive::new(Cursor::new(bytes)).map_err(damaged)?;
    let mut left = limits.max_bytes;
    for index in 0..archive.len() {
        let entry = archive.by_index(index).map_err(damaged)?;
        let size = std::io::copy(&mut entry.take(left + 1), &mut std::io::sink()).map_err(damaged)?;
        left = left.checked_sub(size).ok_or(Problem::TooManyBytes { limit: limits.max_bytes })?;
    }
    Ok(())
}

impl Container for Excel {
    fn arrays(&self) -> &[Array] {
        &self.arrays
    }

    fn values(&mut self, index: usize) -> Result<Vec<f64>, Fault> {
        let stored = &self.stored[index];
        let value = |sample: usize| match stored.cells.get(&(stored.first_row + sample as u32)) {
            None => Ok(f64::NAN),
            Some(Cell::Number(value) | Cell::Time(value)) => Ok(*value),
            Some(Cell::Text(text)) => {
                Err(Fault { row: Some(self.row(index, sample)), problem: Problem::NotANumber(excerpt(text).into()) })
            }
        };
        (0..self.arrays[index].len()).map(value).collect()
    }

    fn row(&self, index: usize, sample: usize) -> Row {
        Row::Sheet(u64::from(self.stored[index].first_row) + sample as u64 + 1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_have_the_letters_of_spreadsheets() {
        assert_eq!([0, 25, 26, 51, 52, 701, 702].map(letters), ["A", "Z", "AA", "AZ", "BA", "ZZ", "AAA"]);
    }
}
