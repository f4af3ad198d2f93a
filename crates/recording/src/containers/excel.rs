//! Spreadsheets: a signal `Sheet1!B` per column with numbers, which its header, if any, also names.
//!
//! The numbers begin below the last of the first rows that contain only texts. That row contains the names of the
//! columns. If it contains a known unit, it is the row of units, and the names are in the row above.

use std::collections::BTreeMap;
use std::io::{Cursor, Read};

use calamine::{DataRef, DataType, Reader, Xlsx};

use super::{Array, Container, Fault, Format};
use crate::budget::{Budget, short};
use crate::error::{Problem, Row, excerpt};
use crate::units;

/// Maximum number of rows searched for the names of the columns.
const HEAD_ROWS: u32 = 200;

const SECONDS_PER_DAY: f64 = 86_400.0;

/// Memory of a cell in bytes, besides its text.
const CELL_BYTES: usize = 96;

/// Memory of the library in bytes per byte of its parts, when it opens a spreadsheet and afterwards: the list of texts
/// grows by doubling.
const OPENING_BYTES: usize = 8;
const OPEN_BYTES: usize = 2;

enum Cell {
    Number(f64),
    /// A time, in s.
    Time(f64),
    Text(Box<str>),
}

impl Cell {
    /// A cell with the beginning of a text.
    fn text(text: &str) -> Self {
        Self::Text(short(text).into())
    }
}

/// The cells of a sheet, by column and row.
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
    pub(super) fn open(bytes: Vec<u8>, budget: &Budget) -> Result<Self, Problem> {
        let mut found = Self { arrays: vec![], stored: vec![] };
        let (longest, all) = check_archive(&bytes, budget)?;
        let mut book = Xlsx::new(Cursor::new(bytes)).map_err(damaged)?;
        budget.release((OPENING_BYTES - OPEN_BYTES) * all);
        for name in book.sheet_names() {
            // Several sheets can refer to one part of the archive, and the library searches the list of sheets.
            budget.work("sheets", longest)?;
            let mut sheet = Sheet::new();
            let mut cells = book.worksheet_cells_reader(&name).map_err(damaged)?;
            while let Some(cell) = cells.next_cell().map_err(damaged)? {
                let text = match cell.get_value() {
                    DataRef::SharedString(text) => Some(*text),
                    DataRef::String(text) => Some(text.as_str()),
                    _ => None,
                };
                if let Some(content) = content(cell.get_value(), text) {
                    keep(&mut sheet, cell.get_position(), content, budget)?;
                }
            }
            found.sheet(&name, sheet, budget)?;
        }
        if super::has_signals(&found.arrays) { Ok(found) } else { Err(Problem::no_signal(Format::Excel, &[])) }
    }

    fn sheet(&mut self, name: &str, mut sheet: Sheet, budget: &Budget) -> Result<(), Problem> {
        budget.check_name(name.len())?;
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
            let array = budget.array(&format!("{name}!{}", letters(*column)), vec![len])?;
            self.arrays.push(Array { aliases, label, unit, ..array });
            self.stored.push(Stored { first_row, cells });
        }
        Ok(())
    }
}

/// The content of a cell; `None` if it is empty.
fn content(value: &impl DataType, text: Option<&str>) -> Option<Cell> {
    Some(match (text, value.as_f64()) {
        (Some(text), _) => Cell::text(text),
        (None, _) if value.is_empty() => return None,
        (None, Some(days)) if value.is_datetime() => Cell::Time(days * SECONDS_PER_DAY),
        (None, Some(number)) => Cell::Number(number),
        (None, None) => Cell::text(&value.as_string().unwrap_or_else(|| "an error".into())),
    })
}

/// Adds a cell to a sheet, unless it is blank.
fn keep(sheet: &mut Sheet, (row, column): (u32, u32), cell: Cell, budget: &Budget) -> Result<(), Problem> {
    let text_bytes = match &cell {
        Cell::Text(text) if text.trim().is_empty() => return Ok(()),
        Cell::Text(text) => text.len(),
        Cell::Number(_) | Cell::Time(_) => 0,
    };
    budget.hold("cells", CELL_BYTES + text_bytes)?;
    sheet.entry(column).or_default().insert(row, cell);
    Ok(())
}

/// The letters of a column, counted from 0: A to Z, AA, …
fn letters(column: u32) -> String {
    let last = char::from(b'A' + (column % 26) as u8);
    if column < 26 { last.to_string() } else { format!("{}{last}", letters(column / 26 - 1)) }
}

/// Checks that the decompressed content of a file is within the budget, and its list of texts. It decompresses the file, because
/// the stated sizes can be wrong. Returns the size of the longest part and of all parts, in bytes.
fn check_archive(bytes: &[u8], budget: &Budget) -> Result<(usize, usize), Problem> {
    const CHUNK_BYTES: usize = 64 << 10;
    let mut archive = zip::ZipArchive::new(Cursor::new(bytes)).map_err(damaged)?;
    let (mut longest, mut all) = (0, 0);
    let mut chunk = vec![0; CHUNK_BYTES];
    for index in 0..archive.len() {
        let mut entry = archive.by_index(index).map_err(damaged)?;
        if entry.name_raw() == b"xl/workbook.bin" {
            return Err(Problem::NotRead(Format::Xlsb));
        }
        let has_texts = entry.name_raw().to_ascii_lowercase().ends_with(b"sharedstrings.xml");
        let mut texts = StatedTexts::default();
        let mut size = 0;
        loop {
            let count = entry.read(&mut chunk).map_err(damaged)?;
            if count == 0 {
                break;
            }
            size += count;
            budget.hold("decompressed content", OPENING_BYTES * count)?;
            if has_texts {
                texts.push(&chunk[..count]);
            }
        }
        if texts.largest > size {
            return Err(damaged("its list of texts states more texts than it has bytes"));
        }
        longest = longest.max(size);
        all += size;
    }
    Ok((longest, all))
}

/// The number of texts that the list of texts states, for which the library takes memory at once.
#[derive(Default)]
struct StatedTexts {
    /// The last bytes, and the value of the attribute if it is being read.
    last: [u8; StatedTexts::NAME.len()],
    stated: Option<usize>,
    largest: usize,
}

impl StatedTexts {
    const NAME: &[u8] = b"uniqueCount=";

    fn push(&mut self, bytes: &[u8]) {
        // Spaces are allowed around the equals sign, and texts of two bytes per character have zeros.
        for byte in bytes.iter().filter(|byte| !byte.is_ascii_whitespace() && **byte != 0) {
            self.stated = match (self.stated, byte) {
                (None, b'"' | b'\'') if self.last == Self::NAME => Some(0),
                (Some(stated), b'0'..=b'9') => Some(stated.saturating_mul(10).saturating_add(usize::from(byte - b'0'))),
                (Some(stated), b'+') => Some(stated),
                (Some(_), _) | (None, _) => None,
            };
            self.largest = self.largest.max(self.stated.unwrap_or(0));
            self.last.rotate_left(1);
            self.last[Self::NAME.len() - 1] = *byte;
        }
    }
}

impl Container for Excel {
    fn arrays(&self) -> &[Array] {
        &self.arrays
    }

    fn values(&mut self, index: usize, budget: &Budget) -> Result<Vec<f64>, Fault> {
        budget.values(self.arrays[index].len())?;
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
    fn the_stated_number_of_texts_is_found_across_chunks() {
        let found = |text: &str, step: usize| {
            let mut texts = StatedTexts::default();
            text.as_bytes().chunks(step).for_each(|chunk| texts.push(chunk));
            texts.largest
        };
        for step in 1..9 {
            assert_eq!(found("<sst count=\"9000\" uniqueCount=\"4000\"><si/>70", step), 4000, "{step}");
            assert_eq!(found("<sst uniquniqueCount = '12'>", step), 12, "{step}");
            assert_eq!(found("<sst count='7'>uniqueCount</sst>", step), 0, "{step}");
        }
        assert_eq!(found("uniqueCount='99999999999999999999999'", 5), usize::MAX);
    }

    #[test]
    fn columns_have_the_letters_of_spreadsheets() {
        assert_eq!([0, 25, 26, 51, 52, 701, 702].map(letters), ["A", "Z", "AA", "AZ", "BA", "ZZ", "AAA"]);
    }
}
