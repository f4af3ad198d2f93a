//! Microsoft's compound files, which hold old spreadsheets, by "[MS-CFB]": a file system of streams in one file.
//!
//! A table gives for each sector the next one of its stream. A chain of sectors is never longer than the table, so that
//! cycles are errors.

use super::Format;
use super::bytes::{Cursor, Order};
use crate::budget::Budget;
use crate::error::Problem;

const HEADER_BYTES: usize = 512;
const ENTRY_BYTES: usize = 128;

/// Sectors of a stream that is shorter than the limit have 64 bytes, in the stream of the root.
const MINI_SHIFT: u32 = 6;
const MINI_LIMIT: usize = 4096;

/// The numbers from here on are no sectors.
const FIRST_RESERVED: u32 = 0xffff_fffa;

const ROOT: u8 = 5;
const STREAM: u8 = 2;

fn damaged() -> Problem {
    Format::Excel.damaged("its compound file is damaged")
}

struct Entry {
    name: String,
    kind: u8,
    start: u32,
    size: usize,
}

struct Sectors<'a> {
    bytes: &'a [u8],
    shift: u32,
    /// Number of bytes before the first sector.
    before: usize,
    next: Vec<u32>,
}

impl Sectors<'_> {
    fn sector(&self, number: u32) -> Option<&[u8]> {
        let start = self.before.checked_add((number as usize).checked_shl(self.shift)?)?;
        let rest = self.bytes.get(start..)?;
        // The last sector of a file can be shorter.
        (!rest.is_empty()).then(|| &rest[..rest.len().min(1 << self.shift)])
    }

    /// The bytes of a chain of sectors.
    fn chain(&self, start: u32, size: usize, budget: &Budget) -> Result<Vec<u8>, Problem> {
        let mut bytes = vec![];
        let mut number = start;
        while number < FIRST_RESERVED && bytes.len() < size {
            let sector = self.sector(number).ok_or_else(damaged)?;
            // A longer chain has a cycle.
            if bytes.len() > self.bytes.len() {
                return Err(damaged());
            }
            budget.hold("streams", sector.len())?;
            bytes.extend_from_slice(sector);
            number = *self.next.get(number as usize).ok_or_else(damaged)?;
        }
        bytes.truncate(size);
        Ok(bytes)
    }
}

fn numbers(bytes: &[u8]) -> Vec<u32> {
    bytes.chunks_exact(4).filter_map(|four| Some(u32::from_le_bytes(*four.first_chunk()?))).collect()
}

/// Reads the stream with one of the names, in the order of the names.
pub(super) fn stream(bytes: &[u8], names: &[&str], budget: &Budget) -> Result<Vec<u8>, Problem> {
    let at = |offset: usize| Cursor { at: offset, ..Cursor::new(bytes, Order::Little) };
    let word = |offset: usize| at(offset).u32().ok_or_else(damaged);
    let shift = word(28)? >> 16;
    if !matches!(shift, 9 | 12) || word(32)? & 0xffff != MINI_SHIFT {
        return Err(damaged());
    }
    let mut sectors = Sectors { bytes, shift, before: 1 << shift, next: vec![] };
    // The table is in sectors that the header lists, and after those a chain of further lists.
    let mut table = numbers(bytes.get(76..HEADER_BYTES).ok_or_else(damaged)?);
    let mut list = word(68)?;
    while list < FIRST_RESERVED {
        let mut more = numbers(sectors.sector(list).ok_or_else(damaged)?);
        list = more.pop().ok_or_else(damaged)?;
        table.extend(more);
        if 4 * table.len() > bytes.len() {
            return Err(damaged());
        }
    }
    for number in table.into_iter().filter(|number| *number < FIRST_RESERVED) {
        let sector = numbers(sectors.sector(number).ok_or_else(damaged)?);
        budget.hold("streams", 4 * sector.len())?;
        sectors.next.extend(sector);
    }
    let directory = sectors.chain(word(48)?, usize::MAX, budget)?;
    let entries: Vec<Entry> = directory.chunks_exact(ENTRY_BYTES).filter_map(entry).collect();
    let wanted = names
        .iter()
        .find_map(|name| entries.iter().find(|entry| entry.kind == STREAM && entry.name.eq_ignore_ascii_case(name)));
    let wanted = wanted.ok_or_else(|| Format::Excel.damaged("it has no workbook"))?;
    if wanted.size >= MINI_LIMIT {
        return sectors.chain(wanted.start, wanted.size, budget);
    }
    let root = entries.iter().find(|entry| entry.kind == ROOT).ok_or_else(damaged)?;
    let mini = sectors.chain(root.start, root.size, budget)?;
    let next = numbers(&sectors.chain(word(60)?, usize::MAX, budget)?);
    Sectors { bytes: &mini, shift: MINI_SHIFT, before: 0, next }.chain(wanted.start, wanted.size, budget)
}

fn entry(bytes: &[u8]) -> Option<Entry> {
    let units: Vec<u16> = bytes.get(..64)?.chunks_exact(2).map(|two| u16::from_le_bytes([two[0], two[1]])).collect();
    let length = units.iter().position(|unit| *unit == 0).unwrap_or(units.len());
    let mut cursor = Cursor::new(bytes, Order::Little);
    cursor.at = 116;
    Some(Entry {
        name: String::from_utf16_lossy(&units[..length]),
        kind: *bytes.get(66)?,
        start: cursor.u32()?,
        size: cursor.index()?,
    })
}
