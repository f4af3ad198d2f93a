//! Decompresses the chunks of an MCAP log, whose writers use Zstandard or LZ4 by default.
//!
//! A record is an operation code of one byte, the length of its content in eight, and the content. A chunk holds
//! records: its content is two times of eight bytes, the size of the records (8), their check sum (4), the name of the
//! compression and the compressed records, each after its length (4 and 8).

use std::borrow::Cow;
use std::ops::Range;

use flate2::Crc;

use super::Format;
use super::bytes::{Cursor, Order};
use super::unpack;
use crate::budget::{Budget, recover};
use crate::error::Problem;

const MAGIC: usize = 8;
const CHUNK: u8 = 0x06;
const DATA_END: u8 = 0x0f;
const FOOTER: u8 = 0x02;

/// The size of the operation code and the length of a record.
const HEAD: usize = 1 + 8;

/// The size of the fields of a chunk before the name of the compression.
const CHUNK_HEAD: usize = 8 + 8 + 8 + 4;

/// A record: where it begins in the log, its operation code and its content.
type Record<'a> = (usize, u8, &'a [u8]);

/// The complete records of a log.
fn records(log: &[u8]) -> impl Iterator<Item = Record<'_>> {
    let mut cursor = Cursor::new(log, Order::Little);
    cursor.at = MAGIC;
    std::iter::from_fn(move || {
        let from = cursor.at;
        let code = *cursor.take(1)?.first()?;
        let length = usize::try_from(cursor.u64()?).ok()?;
        Some((from, code, cursor.take(length)?))
    })
}

/// Returns a log whose chunks are not compressed, with their checksums. Checks the checksums of the log that a log with
/// other chunks cannot have.
pub(super) fn decompressed<'a>(log: &'a [u8], budget: &Budget) -> Result<Cow<'a, [u8]>, Problem> {
    budget.work("records", log.len())?;
    check_sums(log)?;
    let is_compressed = |(_, code, content): Record<'_>| {
        let mut cursor = Cursor::new(content, Order::Little);
        code == CHUNK && cursor.take(CHUNK_HEAD).and_then(|_| cursor.u32()).is_some_and(|length| length > 0)
    };
    if !records(log).any(is_compressed) {
        return Ok(Cow::Borrowed(log));
    }
    let mut plain = log[..MAGIC].to_vec();
    let mut end = MAGIC;
    for (from, code, content) in records(log) {
        end = from + HEAD + content.len();
        let chunk = if code == CHUNK { chunk(content, budget)? } else { None };
        match (code, chunk) {
            (_, Some(content)) => {
                plain.push(code);
                plain.extend_from_slice(&(content.len() as u64).to_le_bytes());
                plain.extend_from_slice(&content);
            }
            // A checksum of 0 stands for none: that of the log covers the compressed chunks.
            (DATA_END, None) => plain.extend_from_slice(&[DATA_END, 4, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0]),
            (_, None) => {
                budget.hold("records", content.len())?;
                plain.extend_from_slice(&log[from..end]);
            }
        }
    }
    // The library reports a record that is cut off.
    plain.extend_from_slice(&log[end..]);
    Ok(Cow::Owned(plain))
}

/// Checks the checksums of the data section and of the summary. A checksum of 0 stands for none.
fn check_sums(log: &[u8]) -> Result<(), Problem> {
    let check = |range: Range<usize>, stated: u32, part: &str| {
        let mut sum = Crc::new();
        sum.update(log.get(range).unwrap_or_default());
        if stated == 0 || stated == sum.sum() {
            return Ok(());
        }
        Err(Format::Mcap.damaged(format!("the checksum of {part} is wrong")))
    };
    for (from, code, content) in records(log) {
        let mut cursor = Cursor::new(content, Order::Little);
        match code {
            DATA_END => check(0..from, cursor.u32().unwrap_or(0), "its data")?,
            FOOTER => {
                let start = cursor.u64().and_then(|start| usize::try_from(start).ok()).unwrap_or(0);
                let start = if start == 0 { from } else { start };
                cursor.u64();
                // It covers the fields of the footer before it.
                check(start..from + HEAD + 16, cursor.u32().unwrap_or(0), "its summary")?;
            }
            _ => {}
        }
    }
    Ok(())
}

/// The content of a chunk with decompressed records; `None` if they are not compressed.
fn chunk(content: &[u8], budget: &Budget) -> Result<Option<Vec<u8>>, Problem> {
    let cut_off = || Format::Mcap.damaged("a chunk is cut off");
    let mut cursor = Cursor::new(content, Order::Little);
    let head = cursor.take(CHUNK_HEAD).ok_or_else(cut_off)?;
    let name = cursor.index().and_then(|length| cursor.take(length)).ok_or_else(cut_off)?;
    let records = cursor.u64().and_then(|length| cursor.take(usize::try_from(length).ok()?)).ok_or_else(cut_off)?;
    let records = match name {
        b"" => return Ok(None),
        b"zstd" => unpack::zstd(records, budget),
        b"lz4" => unpack::lz4(records, budget),
        other => {
            let name = String::from_utf8_lossy(other);
            return Err(Format::Mcap.damaged(format!("its chunks are compressed by '{name}'; zstd and lz4 are read")));
        }
    };
    let records = records.map_err(|error| recover(Format::Mcap, error))?;
    let mut plain = head.to_vec();
    plain.extend_from_slice(&0_u32.to_le_bytes());
    plain.extend_from_slice(&(records.len() as u64).to_le_bytes());
    plain.extend_from_slice(&records);
    Ok(Some(plain))
}
