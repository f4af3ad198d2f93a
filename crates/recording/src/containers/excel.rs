//! Spreadsheets: a signal `Sheet1!B` per column with numbers, which its header, if any, also names.
//!
//! The numbers begin below the last of the first rows that contain only texts. That row contains the names of the
//! columns. If it contains a known unit, it is the row of units, and the names are in the row above.

use std::collections::BTreeMap;
use std::io::Cursor;

use calamine::{DataRef, DataType, Reader, Xlsx};

use super::{Array, Container, Fault, Format};
use crate::error::{Problem, Row, excerpt};
use crate::room::{Room, check_name, recover, short};
use crate::units;

const HEAD_ROWS: u32 = 200;

const SECONDS_PER_DAY: f64 = 86_400.0;

/// Bytes of a cell besides its text.
const CELL_BYTES: usize = 96;

enum Cell {
    Number(f64),
    /// In s.
    Time(f64),
    Text(Box<str>),
}

impl Cell {
    fn text(text: &str) -> Self {
        Self::Text(short(text).into())
    }
}

/// By column and row.
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
    pub(super) fn open(bytes: Vec<u8>, room: &Room) -> Result<Self, Problem> {
        let mut found = Self { arrays: vec![], stored: vec![] };
        let longest = check_archive(&bytes, room)?;
        let mut book = Xlsx::new(Cursor::new(bytes)).map_err(damaged)?;
        for name in book.sheet_names() {
            // Several sheets can refer to one part of the archive.
            room.take(longest)?;
            let mut sheet = Sheet::new();
            let mut cells = book.worksheet_cells_reader(&name).map_err(damaged)?;
            while let Some(cell) = cells.next_cell().map_err(damaged)? {
                let text = match cell.get_value() {
                    DataRef::SharedString(text) => Some(*text),
                    DataRef::String(text) => Some(text.as_str()),
                    _ => None,
                };
                if let Some(content) = content(cell.get_value(), text) {
                    keep(&mut sheet, cell.get_position(), content, room)?;
                }
            }
            found.sheet(&name, sheet, room)?;
        }
        if super::has_signals(&found.arrays) { Ok(found) } else { Err(Problem::no_signal(Format::Excel, &[])) }
    }

    fn sheet(&mut self, name: &str, mut sheet: Sheet, room: &Room) -> Result<(), Problem> {
        check_name(name.len())?;
        let texts = |row: u32| {
            sheet.values().filter_map(move |cells| match cells.get(&row) {
                Some(Cell::Text(text)) => Some(&**text),
                _ => None,
            })
        };
        let mut text_rows = BTreeMap::<u32, bool>::new();
        for (row, cell) in sheet.values().flat_map(|cells| cells.range(..HEAD_ROWS)) {
            *text_rows.entry(*row).or_insert(true) &= matches!(cell, Cell::Text(_));
        }
        let last_texts =
            |below: u32| text_rows.range(..below).rev().find(|(_, is_text)| **is_text).map(|(row, _)| *row);
        let mut header = last_texts(HEAD_ROWS);
        let first_row = header.map_or(0, |row| row + 1);
        let mut units = None;
        if header.is_some_and(|row| texts(row).any(units::is_known)) {
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
            let array = Array::in_room(&format!("{name}!{}", letters(*column)), vec![len], room)?;
            self.arrays.push(Array { aliases, label, unit, ..array });
            self.stored.push(Stored { first_row, cells });
        }
        Ok(())
    }
}

fn content(value: &impl DataType, text: Option<&str>) -> Option<Cell> {
    Some(match (text, value.as_f64()) {
        (Some(text), _) => Cell::text(text),
        (None, _) if value.is_empty() => return None,
        (None, Some(days)) if value.is_datetime() => Cell::Time(days * SECONDS_PER_DAY),
        (None, Some(number)) => Cell::Number(number),
        (None, None) => Cell::text(&value.as_string().unwrap_or_else(|| "an error".into())),
    })
}

fn keep(sheet: &mut Sheet, (row, column): (u32, u32), cell: Cell, room: &Room) -> Result<(), Problem> {
    let text_bytes = match &cell {
        Cell::Text(text) if text.trim().is_empty() => return Ok(()),
        Cell::Text(text) => text.len(),
        Cell::Number(_) | Cell::Time(_) => 0,
    };
    room.take(CELL_BYTES + text_bytes)?;
    sheet.entry(column).or_default().insert(row, cell);
    Ok(())
}

/// A to Z, AA, …
fn letters(column: u32) -> String {
    let last = char::from(b'A' + (column % 26) as u8);
    if column < 26 { last.to_string() } else { format!("{}{last}", letters(column / 26 - 1)) }
}

/// Checks the stated sizes, for which the library allocates memory. Returns the size of the longest part in bytes.
fn check_archive(bytes: &[u8], room: &Room) -> Result<usize, Problem> {
    let mut archive = zip::ZipArchive::new(Cursor::new(bytes)).map_err(damaged)?;
    let mut longest = 0;
    for index in 0..archive.len() {
        let entry = archive.by_index(index).map_err(damaged)?;
        if entry.name_raw() == b"xl/workbook.bin" {
            return Err(Problem::NotRead(Format::Xlsb));
        }
        let has_texts = entry.name_raw().to_ascii_lowercase().ends_with(b"sharedstrings.xml");
        let content = room.read(entry).map_err(|error| recover(Format::Excel, error))?;
        if has_texts && stated_texts(&content) > content.len() {
            return Err(damaged("its list of texts states more texts than it has bytes"));
        }
        longest = longest.max(content.len());
    }
    Ok(longest)
}

fn stated_texts(content: &[u8]) -> usize {
    let content = String::from_utf8_lossy(content);
    let stated = content.split("uniqueCount").skip(1).filter_map(|rest| {
        let value = rest.trim_start().strip_prefix('=')?.trim_start().trim_start_matches(['"', '\'', '+']);
        let digits = value.find(|character: char| !character.is_ascii_digit()).map_or(value, |end| &value[..end]);
        Some(digits.parse().unwrap_or(if digits.is_empty() { 0 } else { usize::MAX }))
    });
    stated.max().unwrap_or(0)
}

impl Container for Excel {
    fn arrays(&self) -> &[Array] {
        &self.arrays
    }

    fn values(&mut self, index: usize, _: &Room) -> Result<Vec<f64>, Fault> {
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
    fn the_stated_number_of_texts_is_found() {
        for (text, count) in [
            ("<sst count=\"9000\" uniqueCount=\"4000\"><si/>70", 4000),
            ("<sst uniqueCount = '12'>", 12),
            ("<sst count='7'>uniqueCount</sst>", 0),
            ("uniqueCount='99999999999999999999999'", usize::MAX),
        ] {
            assert_eq!(stated_texts(text.as_bytes()), count, "{text}");
        }
    }

    #[test]
    fn columns_have_the_letters_of_spreadsheets() {
        assert_eq!([0, 25, 26, 51, 52, 701, 702].map(letters), ["A", "Z", "AA", "AZ", "BA", "ZZ", "AAA"]);
    }
}
