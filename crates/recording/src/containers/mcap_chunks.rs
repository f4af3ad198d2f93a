//! Decompresses the chunks of an MCAP log, whose writers use Zstandard or LZ4 by default.
//!
//! A record is an operation code of one byte, the length of its content in eight, and the content. A chunk holds
//! records: its content is two times of eight bytes, the size of the records (8), their check sum (4), the name of the
//! compression and the compressed records, each after its length (4 and 8).

use std::borrow::Cow;

use super::Format;
use super::bytes::{Cursor, Order};
use super::unpack;
use crate::Limits;
use crate::error::Problem;

const MAGIC: usize = 8;
const CHUNK: u8 = 0x06;
const DATA_END: u8 = 0x0f;

/// The size of the fields of a chunk before the name of the compression.
const CHUNK_HEAD: usize = 8 + 8 + 8 + 4;

/// Returns a log whose chunks are not compressed, with their check sums.
pub(super) fn decompressed<'a>(log: &'a [u8], limits: &Limits) -> Result<Cow<'a, [u8]>, Problem> {
    let Some(rest) = log.get(MAGIC..) else { return Ok(Cow::Borrowed(log)) };
    let mut plain = log[..MAGIC].to_vec();
    let mut cursor = Cursor::new(rest, Order::Little);
    let mut has_compressed = false;
    while let Some(&code) = cursor.rest().first() {
        let record = cursor.rest();
        let content =
            cursor.take(1).and_then(|_| cursor.u64()).and_then(|length| cursor.take(usize::try_from(length).ok()?));
        // The library reports a record that is cut off.
        let Some(content) = content else {
            plain.extend_from_slice(record);
            break;
        };
        match code {
            CHUNK => {
                let left = limits.max_bytes.saturating_sub(plain.len() as u64);
                match chunk(content, left)? {
                    Some(content) => {
                        has_compressed = true;
                        plain.push(code);
                        plain.extend_from_slice(&(content.len() as u64).to_le_bytes());
                        plain.extend_from_slice(&content);
                    }
                    None => plain.extend_from_slice(&record[..9 + content.len()]),
                }
                if plain.len() as u64 > limits.max_bytes {
                    return Err(Problem::TooManyBytes { limit: limits.max_bytes });
                }
            }
            // A check sum of 0 stands for none: that of the file covers the compressed chunks.
            DATA_END => plain.extend_from_slice(&[DATA_END, 4, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0]),
            _ => plain.extend_from_slice(&record[..9 + content.len()]),
        }
    }
    Ok(if has_compressed { Cow::Owned(plain) } else { Cow::Borrowed(log) })
}

/// The content of a chunk with decompressed records; `None` if they are not compressed.
fn chunk(content: &[u8], left: u64) -> Result<Option<Vec<u8>>, Problem> {
    let cut_off = || Format::Mcap.damaged("a chunk is cut off");
    let mut cursor = Cursor::new(content, Order::Little);
    let head = cursor.take(CHUNK_HEAD).ok_or_else(cut_off)?;
    let name = cursor.index().and_then(|length| cursor.take(length)).ok_or_else(cut_off)?;
    let records = cursor.u64().and_then(|length| cursor.take(usize::try_from(length).ok()?)).ok_or_else(cut_off)?;
    let records = match name {
        b"" => return Ok(None),
        b"zstd" => unpack::zstd(records, left),
        b"lz4" => unpack::lz4(records, left),
        other => {
            let name = String::from_utf8_lossy(other);
            return Err(Format::Mcap.damaged(format!("its chunks are compressed by '{name}'; zstd and lz4 are read")));
        }
    };
    let records = records.map_err(|error| Format::Mcap.damaged(format!("a chunk cannot be decompressed: {error}")))?;
    let mut plain = head.to_vec();
    plain.extend_from_slice(&0_u32.to_le_bytes());
    plain.extend_from_slice(&(records.len() as u64).to_le_bytes());
    plain.extend_from_slice(&records);
    Ok(Some(plain))
}
