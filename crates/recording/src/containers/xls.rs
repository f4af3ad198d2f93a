//! The workbook in an old spreadsheet (`.xls`), by "[MS-XLS]": numbers, texts and times of its cells. A workbook is a
//! sequence of records, with a list of the sheets and of the texts that cells share.

use super::Format;
use super::bytes::{Cursor, Order, Scalar};
use super::compound_file;
use super::excel::{Cell, SECONDS_PER_DAY, Sheet, keep};
use crate::budget::{Budget, short};
use crate::error::Problem;

const END: u16 = 0x000a;
const BEGIN: u16 = 0x0809;
const CONTINUE: u16 = 0x003c;

/// Numbers of the built-in formats of dates and times.
fn is_time_format(number: u16) -> bool {
    matches!(number, 14..=22 | 27..=36 | 45..=47 | 50..=58)
}

fn damaged() -> Problem {
    Format::Excel.damaged("a record of its workbook is damaged")
}

/// A sheet with its place in the workbook.
struct Place {
    name: String,
    start: usize,
}

#[derive(Default)]
struct Book {
    places: Vec<Place>,
    /// True for the version of 1997 and later, whose texts state their encoding.
    has_flags: bool,
    /// The texts that cells share.
    texts: Vec<String>,
    /// The format of each style of cells, and the formats of times.
    styles: Vec<u16>,
    times: Vec<u16>,
}

/// A record: its type and its content.
type Record<'a> = (u16, &'a [u8]);

fn records<'a>(bytes: &'a [u8], start: usize) -> impl Iterator<Item = Record<'a>> {
    let mut cursor = Cursor::new(bytes, Order::Little);
    cursor.at = start;
    std::iter::from_fn(move || {
        let head = cursor.u32()?;
        Some((head as u16, cursor.take((head >> 16) as usize)?))
    })
}

/// Reads the sheets of a workbook, with their names.
pub(super) fn sheets(bytes: &[u8], budget: &Budget) -> Result<Vec<(String, Sheet)>, Problem> {
    let stream = compound_file::stream(bytes, &["Workbook", "Book"], budget)?;
    let book = Book::read(&stream, budget)?;
    let mut sheets = vec![];
    for place in &book.places {
        sheets.push((place.name.clone(), book.sheet(&stream, place.start, budget)?));
    }
    Ok(sheets)
}

fn word(bytes: &[u8], at: usize) -> Option<u16> {
    Some(u16::from_le_bytes(*bytes.get(at..)?.first_chunk()?))
}

impl Book {
    fn read(stream: &[u8], budget: &Budget) -> Result<Self, Problem> {
        let mut book = Self::default();
        let mut all = records(stream, 0).peekable();
        while let Some((kind, content)) = all.next() {
            budget.work("records", 4 + content.len())?;
            match kind {
                BEGIN => book.has_flags = word(content, 0) == Some(0x0600),
                // The key of an encrypted workbook.
                0x002f if word(content, 0) != Some(0) => return Err(Format::Excel.damaged("it is encrypted")),
                0x0085 => {
                    if let Some(place) = book.place(content) {
                        budget.hold("sheets", 1024)?;
                        book.places.push(place);
                    }
                }
                0x00e0 => {
                    budget.hold("records", size_of::<u16>())?;
                    book.styles.push(word(content, 2).ok_or_else(damaged)?);
                }
                0x041e => book.format(content),
                0x00fc => {
                    let mut parts = vec![content.get(8..).unwrap_or_default()];
                    while let Some((_, more)) = all.next_if(|(kind, _)| *kind == CONTINUE) {
                        parts.push(more);
                    }
                    book.texts = Texts::new(parts).read(budget)?;
                }
                END => break,
                _ => {}
            }
        }
        Ok(book)
    }

    /// The name and the place of a sheet; `None` for charts and macros.
    fn place(&self, content: &[u8]) -> Option<Place> {
        let mut cursor = Cursor::new(content, Order::Little);
        let start = cursor.index()?;
        let [_, kind, length] = *cursor.take(3)?.first_chunk()?;
        (kind == 0).then_some(())?;
        Some(Place { name: short(&self.text(cursor.rest(), usize::from(length))), start })
    }

    /// The text of `length` characters in a record.
    fn text(&self, bytes: &[u8], length: usize) -> String {
        let (is_wide, bytes) = match bytes.split_first() {
            Some((flags, rest)) if self.has_flags => (flags & 1 == 1, rest),
            _ => (false, bytes),
        };
        characters(bytes, length, is_wide)
    }

    fn format(&mut self, content: &[u8]) {
        let (Some(number), Some(length)) = (word(content, 0), word(content, 2)) else { return };
        let (length, rest) = match self.has_flags {
            true => (usize::from(length), content.get(4..)),
            false => (usize::from(length & 0xff), content.get(3..)),
        };
        if is_time(&self.text(rest.unwrap_or_default(), length)) && !self.times.contains(&number) {
            self.times.push(number);
        }
    }

    fn sheet(&self, stream: &[u8], start: usize, budget: &Budget) -> Result<Sheet, Problem> {
        let mut sheet = Sheet::new();
        let mut depth = 0_usize;
        // The cell of a formula whose text follows.
        let mut formula = None;
        for (kind, content) in records(stream, start) {
            budget.work("records", 4 + content.len())?;
            match kind {
                BEGIN => depth += 1,
                END if depth <= 1 => break,
                END => depth -= 1,
                // Parts inside the sheet, such as charts.
                _ if depth > 1 => {}
                0x0207 => {
                    if let (Some(at), Some(length)) = (formula.take(), word(content, 0)) {
                        let text = self.text(content.get(2..).unwrap_or_default(), usize::from(length));
                        keep(&mut sheet, at, Cell::text(&text), budget)?;
                    }
                }
                0x00bd => {
                    self.numbers(&mut sheet, content, budget)?;
                }
                _ => {
                    let Some((at, cell)) = self.cell(kind, content) else { continue };
                    formula = (kind == 0x0006 && cell.is_none()).then_some(at);
                    if let Some(cell) = cell {
                        keep(&mut sheet, at, cell, budget)?;
                    }
                }
            }
        }
        Ok(sheet)
    }

    /// Reads a row of numbers.
    fn numbers(&self, sheet: &mut Sheet, content: &[u8], budget: &Budget) -> Result<(), Problem> {
        let (Some(row), Some(first)) = (word(content, 0), word(content, 2)) else { return Ok(()) };
        let numbers = content.get(4..content.len().saturating_sub(2)).unwrap_or_default();
        for (index, number) in numbers.chunks_exact(6).enumerate() {
            let value = Cursor { at: 2, ..Cursor::new(number, Order::Little) }.u32().map(packed);
            if let (Some(style), Some(value)) = (word(number, 0), value) {
                keep(sheet, (u32::from(row), u32::from(first) + index as u32), self.number(style, value), budget)?;
            }
        }
        Ok(())
    }

    /// The place of a cell and its content, which is `None` if a text follows. `None` for other records.
    fn cell(&self, kind: u16, content: &[u8]) -> Option<((u32, u32), Option<Cell>)> {
        let (row, column, style) = (word(content, 0)?, word(content, 2)?, word(content, 4)?);
        let rest = content.get(6..)?;
        let cell = match kind {
            0x0203 => self.number(style, Scalar::F64.read(rest, Order::Little)?),
            0x027e => self.number(style, packed(Cursor::new(rest, Order::Little).u32()?)),
            0x0204 | 0x00d6 => Cell::text(&self.text(rest.get(2..)?, usize::from(word(rest, 0)?))),
            0x00fd => Cell::text(self.texts.get(Cursor::new(rest, Order::Little).index()?)?),
            0x0205 if *rest.get(1)? == 0 => self.number(style, f64::from(*rest.first()?)),
            0x0205 => Cell::text("an error"),
            0x0006 if rest.get(6..8)? == [0xff, 0xff] => match rest[0] {
                1 => self.number(style, f64::from(rest[2])),
                2 => Cell::text("an error"),
                _ => return Some(((u32::from(row), u32::from(column)), None)),
            },
            0x0006 => self.number(style, Scalar::F64.read(rest, Order::Little)?),
            _ => return None,
        };
        Some(((u32::from(row), u32::from(column)), Some(cell)))
    }

    fn number(&self, style: u16, value: f64) -> Cell {
        let format = self.styles.get(usize::from(style)).copied().unwrap_or(0);
        let is_time = is_time_format(format) || self.times.contains(&format);
        if is_time { Cell::Time(value * SECONDS_PER_DAY) } else { Cell::Number(value) }
    }
}

/// A number in 30 bits: a whole one, or the first bits of a floating-point one; and whether it counts hundredths.
fn packed(bits: u32) -> f64 {
    let number =
        if bits & 2 == 2 { f64::from(bits as i32 >> 2) } else { f64::from_bits(u64::from(bits & 0xffff_fffc) << 32) };
    if bits & 1 == 1 { number / 100.0 } else { number }
}

/// Characters of one byte, or of two.
fn characters(bytes: &[u8], length: usize, is_wide: bool) -> String {
    if is_wide {
        let units: Vec<u16> =
            bytes.chunks_exact(2).take(length).map(|two| u16::from_le_bytes([two[0], two[1]])).collect();
        String::from_utf16_lossy(&units)
    } else {
        bytes.iter().take(length).copied().map(char::from).collect()
    }
}

/// Returns true if a format has a part of a date or a time, outside quotes, brackets and escaped characters.
fn is_time(format: &str) -> bool {
    let mut characters = format.chars();
    while let Some(character) = characters.next() {
        match character {
            '"' => drop(characters.by_ref().find(|character| *character == '"')),
            '\\' | '_' | '*' => drop(characters.next()),
            '[' => {
                let inside: String = characters.by_ref().take_while(|character| *character != ']').collect();
                if !inside.is_empty() && inside.chars().all(|character| "hmsHMS".contains(character)) {
                    return true;
                }
            }
            character if "dmyhsDMYHS".contains(character) => return true,
            _ => {}
        }
    }
    false
}

/// The texts that cells share. A text can continue in the next part, which then begins with its encoding.
struct Texts<'a> {
    parts: std::vec::IntoIter<&'a [u8]>,
    rest: &'a [u8],
}

impl<'a> Texts<'a> {
    fn new(parts: Vec<&'a [u8]>) -> Self {
        Self { parts: parts.into_iter(), rest: &[] }
    }

    fn read(mut self, budget: &Budget) -> Result<Vec<String>, Problem> {
        let mut texts = vec![];
        while let Some(text) = self.text() {
            budget.hold("texts", size_of::<String>() + text.len())?;
            texts.push(text);
        }
        Ok(texts)
    }

    /// Begins the next part if the present one has ended.
    fn fill(&mut self) -> Option<bool> {
        if self.rest.is_empty() {
            self.rest = self.parts.find(|part| !part.is_empty())?;
            return Some(true);
        }
        Some(false)
    }

    fn byte(&mut self) -> Option<u8> {
        self.fill()?;
        let (first, rest) = self.rest.split_first()?;
        self.rest = rest;
        Some(*first)
    }

    fn number(&mut self, bytes: u32) -> Option<usize> {
        (0..bytes).try_fold(0, |sum, index| Some(sum | usize::from(self.byte()?) << (8 * index)))
    }

    fn text(&mut self) -> Option<String> {
        let mut left = self.number(2)?;
        let flags = self.byte()?;
        let runs = if flags & 8 == 8 { self.number(2)? } else { 0 };
        let extension = if flags & 4 == 4 { self.number(4)? } else { 0 };
        let mut is_wide = flags & 1 == 1;
        let mut text = String::new();
        while left > 0 {
            if self.fill()? {
                is_wide = self.byte()? & 1 == 1;
            }
            let size = if is_wide { 2 } else { 1 };
            let count = (self.rest.len() / size).min(left);
            if count == 0 {
                return None;
            }
            // Cells need the beginning of a text only.
            if text.len() < 1000 {
                text.push_str(&characters(self.rest, count, is_wide));
            }
            self.rest = &self.rest[count * size..];
            left -= count;
        }
        let mut skipped = 4 * runs + extension;
        while skipped > 0 {
            self.fill()?;
            let count = skipped.min(self.rest.len());
            self.rest = &self.rest[count..];
            skipped -= count;
        }
        Some(short(&text))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_of_thirty_bits_are_unpacked() {
        // Examples of "[MS-XLS]" 2.5.217.
        assert_eq!(
            [0x3ff0_0000, 0x3ff0_0001, 0x004b_5646, 0x004b_5647].map(packed),
            [1.0, 0.01, 1_234_321.0, 12_343.21]
        );
        assert_eq!(packed((-3_i32 << 2) as u32 | 2), -3.0);
    }

    #[test]
    fn formats_of_times_are_recognised() {
        for format in ["yyyy-mm-dd", "h:mm:ss", "[h]:mm", "0.0\" s\" d"] {
            assert!(is_time(format), "{format}");
        }
        for format in ["General", "0.00", "0.0\" mm\"", "[Red]0.0", "#,##0\\m", "0.00E+00"] {
            assert!(!is_time(format), "{format}");
        }
    }

    #[test]
    fn a_text_continues_in_the_next_part() {
        let parts: Vec<&[u8]> = vec![b"\x04\0\0ab", b"\x01c\0d\0\x02\0\x08\x01\0xy", b"1234\x01\0\0z"];
        let texts = Texts::new(parts).read(&Budget::new(&crate::Limits::default())).expect("within");
        assert_eq!(texts, ["abcd", "xy", "z"]);
    }
}
