//! The pages of a column of a Parquet file, decompressed within the budget of the file, with their checksums checked. The
//! library would take the memory that the description of a page states.

use std::fs::File;
use std::sync::Arc;

use bytes::Bytes;
use parquet::basic::{Compression, Encoding, Type as Physical};
use parquet::column::page::{Page, PageMetadata, PageReader};
use parquet::errors::{ParquetError, Result};
use parquet::file::metadata::ColumnChunkMetaData;
use parquet::file::reader::ChunkReader;

use super::thrift::{Kind, Thrift};
use super::unpack::{self, Unpack};
use crate::budget::Budget;

/// Memory of the decoder in bytes per byte of a page.
const DECODER_BYTES: usize = 2;

pub(super) struct Pages {
    budget: Budget,
    /// The bytes of the column that are not read.
    rest: Bytes,
    unpack: Option<Unpack>,
    /// Size of a value in bytes.
    value_bytes: usize,
    /// Memory of the page that was read last.
    held: usize,
}

fn damaged(reason: &str) -> ParquetError {
    ParquetError::General(reason.into())
}

impl Pages {
    /// The pages of a chunk of a column.
    pub(super) fn of(file: &Arc<File>, chunk: &ColumnChunkMetaData, budget: &Budget) -> Result<Self> {
        let unpack: Option<Unpack> = match chunk.compression() {
            Compression::UNCOMPRESSED => None,
            Compression::SNAPPY => Some(unpack::snappy),
            Compression::GZIP(_) => Some(unpack::gzip),
            Compression::BROTLI(_) => Some(unpack::brotli),
            Compression::ZSTD(_) => Some(unpack::zstd),
            Compression::LZ4_RAW => Some(unpack::lz4_block),
            Compression::LZ4 => Some(unpack::lz4_hadoop),
            other => return Err(damaged(&format!("its pages are compressed by {other}"))),
        };
        let (start, length) = chunk.byte_range();
        let length = usize::try_from(length).map_err(|_| damaged("a column is cut off"))?;
        budget.work("pages", length).map_err(external)?;
        let rest = file.get_bytes(start, length)?;
        let value_bytes = match chunk.column_type() {
            Physical::INT32 | Physical::FLOAT => 4,
            Physical::INT64 | Physical::DOUBLE => 8,
            _ => 1,
        };
        Ok(Self { budget: budget.clone(), rest, unpack, value_bytes, held: 0 })
    }

    /// Decompresses a page, whose first `plain` bytes are not compressed.
    fn unpacked(&mut self, bytes: Bytes, plain: usize, size: usize) -> Result<Bytes> {
        let Some(unpack) = self.unpack else { return Ok(bytes) };
        let (levels, packed) = bytes.split_at_checked(plain).ok_or_else(|| damaged("a page is cut off"))?;
        // A page without values has nothing to decompress.
        let content = if packed.is_empty() { vec![] } else { unpack(packed, &self.budget).map_err(external)? };
        self.held = content.len();
        if levels.len() + content.len() != size {
            return Err(damaged("a page has another size than it states"));
        }
        Ok(if levels.is_empty() { content.into() } else { [levels, &content].concat().into() })
    }

    fn page(&mut self, header: &Header) -> Result<Option<Page>> {
        if header.packed > self.rest.len() {
            return Err(damaged("a page is cut off"));
        }
        let bytes = self.rest.split_to(header.packed);
        if let Some(stated) = header.checksum {
            let mut sum = flate2::Crc::new();
            sum.update(&bytes);
            if sum.sum() != stated {
                return Err(damaged("the checksum of a page is wrong"));
            }
        }
        let num_values = header.values;
        // The levels of all values are decoded in batches; the values of a dictionary at once.
        Ok(match &header.kind {
            Some(PageKind::Data { encoding, definition, repetition }) => Some(Page::DataPage {
                buf: self.unpacked(bytes, 0, header.size)?,
                num_values,
                encoding: *encoding,
                def_level_encoding: *definition,
                rep_level_encoding: *repetition,
                statistics: None,
            }),
            Some(PageKind::Data2 { encoding, nulls, rows, definition_bytes, repetition_bytes, is_compressed }) => {
                let levels = (*definition_bytes as usize).saturating_add(*repetition_bytes as usize);
                if levels > bytes.len() {
                    return Err(damaged("a page is cut off"));
                }
                Some(Page::DataPageV2 {
                    buf: if *is_compressed { self.unpacked(bytes, levels, header.size)? } else { bytes },
                    num_values,
                    encoding: *encoding,
                    num_nulls: *nulls,
                    num_rows: *rows,
                    def_levels_byte_len: *definition_bytes,
                    rep_levels_byte_len: *repetition_bytes,
                    is_compressed: *is_compressed,
                    statistics: None,
                })
            }
            Some(PageKind::Dictionary { encoding, is_sorted }) => {
                let buf = self.unpacked(bytes, 0, header.size)?;
                if (num_values as usize).saturating_mul(self.value_bytes) > buf.len() {
                    return Err(damaged("a dictionary has fewer values than it states"));
                }
                self.budget.hold("pages", DECODER_BYTES * buf.len()).map_err(external)?;
                Some(Page::DictionaryPage { buf, num_values, encoding: *encoding, is_sorted: *is_sorted })
            }
            None => None,
        })
    }
}

fn external(error: impl std::error::Error + Send + Sync + 'static) -> ParquetError {
    ParquetError::External(Box::new(error))
}

/// The description of a page.
struct Header {
    size: usize,
    packed: usize,
    checksum: Option<u32>,
    values: u32,
    /// `None` for a page without values, such as an index.
    kind: Option<PageKind>,
}

enum PageKind {
    Data {
        encoding: Encoding,
        definition: Encoding,
        repetition: Encoding,
    },
    Data2 {
        encoding: Encoding,
        nulls: u32,
        rows: u32,
        definition_bytes: u32,
        repetition_bytes: u32,
        is_compressed: bool,
    },
    Dictionary {
        encoding: Encoding,
        is_sorted: bool,
    },
}

fn encoding(code: i64) -> Option<Encoding> {
    #[expect(deprecated, reason = "old files have it")]
    Some(match code {
        0 => Encoding::PLAIN,
        2 => Encoding::PLAIN_DICTIONARY,
        3 => Encoding::RLE,
        4 => Encoding::BIT_PACKED,
        5 => Encoding::DELTA_BINARY_PACKED,
        6 => Encoding::DELTA_LENGTH_BYTE_ARRAY,
        7 => Encoding::DELTA_BYTE_ARRAY,
        8 => Encoding::RLE_DICTIONARY,
        9 => Encoding::BYTE_STREAM_SPLIT,
        _ => return None,
    })
}

/// Reads the description of a page; `None` if it is damaged.
fn header(thrift: &mut Thrift<'_>) -> Option<Header> {
    let mut header = Header { size: 0, packed: 0, checksum: None, values: 0, kind: None };
    let mut last = 0;
    while let Some((field, kind)) = thrift.field(&mut last)? {
        match (field, kind) {
            (2, Kind::Integer) => header.size = usize::try_from(thrift.integer()?).ok()?,
            (3, Kind::Integer) => header.packed = usize::try_from(thrift.integer()?).ok()?,
            (4, Kind::Integer) => header.checksum = Some(thrift.integer()? as u32),
            (5 | 7 | 8, Kind::Struct) => {
                let numbers = numbers(thrift)?;
                let number = |field: usize| numbers[field];
                let count = |field: usize| u32::try_from(number(field)?).ok();
                header.values = count(1)?;
                header.kind = Some(match field {
                    5 => PageKind::Data {
                        encoding: encoding(number(2)?)?,
                        definition: encoding(number(3)?)?,
                        repetition: encoding(number(4)?)?,
                    },
                    7 => PageKind::Dictionary {
                        encoding: encoding(number(2)?)?,
                        is_sorted: number(3).is_some_and(|sorted| sorted != 0),
                    },
                    _ => PageKind::Data2 {
                        nulls: count(2)?,
                        rows: count(3)?,
                        encoding: encoding(number(4)?)?,
                        definition_bytes: count(5)?,
                        repetition_bytes: count(6)?,
                        is_compressed: number(7).is_none_or(|compressed| compressed != 0),
                    },
                });
            }
            (_, kind) => thrift.skip(kind, 1)?,
        }
    }
    Some(header)
}

/// Reads the numbers and flags of a structure by their fields.
fn numbers(thrift: &mut Thrift<'_>) -> Option<[Option<i64>; 8]> {
    let mut numbers = [None; 8];
    let mut last = 0;
    while let Some((field, kind)) = thrift.field(&mut last)? {
        let number = match kind {
            Kind::Integer => thrift.integer()?,
            Kind::True => 1,
            Kind::False => 0,
            kind => {
                thrift.skip(kind, 2)?;
                continue;
            }
        };
        if let Some(place) = usize::try_from(field).ok().and_then(|field| numbers.get_mut(field)) {
            *place = Some(number);
        }
    }
    Some(numbers)
}

impl PageReader for Pages {
    fn get_next_page(&mut self) -> Result<Option<Page>> {
        self.budget.release(std::mem::take(&mut self.held));
        while !self.rest.is_empty() {
            let mut thrift = Thrift::new(&self.rest);
            let header = header(&mut thrift).ok_or_else(|| damaged("the description of a page is damaged"))?;
            let length = thrift.at();
            self.rest = self.rest.slice(length..);
            if let Some(page) = self.page(&header)? {
                return Ok(Some(page));
            }
        }
        Ok(None)
    }

    fn peek_next_page(&mut self) -> Result<Option<PageMetadata>> {
        Err(damaged("pages are read one after the other"))
    }

    fn skip_next_page(&mut self) -> Result<()> {
        Err(damaged("pages are read one after the other"))
    }

    fn at_record_boundary(&mut self) -> Result<bool> {
        Ok(self.rest.is_empty())
    }
}

impl Iterator for Pages {
    type Item = Result<Page>;

    fn next(&mut self) -> Option<Self::Item> {
        self.get_next_page().transpose()
    }
}
