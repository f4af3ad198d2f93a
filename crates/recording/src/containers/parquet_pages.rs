//! Decompresses the pages of a column of a Parquet file by Zstandard or Brotli, which the library leaves to libraries
//! in C or does not bring. The library reads the pages as if they were not compressed.

use std::fs::File;
use std::sync::Arc;

use parquet::basic::Compression;
use parquet::column::page::{Page, PageMetadata, PageReader};
use parquet::errors::{ParquetError, Result};
use parquet::file::metadata::ColumnChunkMetaData;
use parquet::file::serialized_reader::SerializedPageReader;

use super::unpack;

pub(super) struct Pages {
    inner: SerializedPageReader<File>,
    unpack: fn(&[u8], u64) -> std::io::Result<Vec<u8>>,
    max_bytes: u64,
}

impl Pages {
    /// Returns the pages of a chunk of a column; `None` if the library decompresses them.
    pub(super) fn of(
        file: &Arc<File>,
        chunk: &ColumnChunkMetaData,
        rows: usize,
        max_bytes: u64,
    ) -> Result<Option<Self>> {
        let unpack: fn(&[u8], u64) -> std::io::Result<Vec<u8>> = match chunk.compression() {
            Compression::ZSTD(_) => unpack::zstd,
            Compression::BROTLI(_) => unpack::brotli,
            _ => return Ok(None),
        };
        let plain = chunk.clone().into_builder().set_compression(Compression::UNCOMPRESSED).build()?;
        let inner = SerializedPageReader::new(file.clone(), &plain, rows, None)?;
        Ok(Some(Self { inner, unpack, max_bytes }))
    }

    /// Decompresses a page, whose first `plain` bytes are not compressed.
    fn unpacked(&self, bytes: &[u8], plain: usize) -> Result<Vec<u8>> {
        let (levels, packed) =
            bytes.split_at_checked(plain).ok_or_else(|| ParquetError::General("a page is cut off".into()))?;
        let mut all = levels.to_vec();
        // A page without values has nothing to decompress.
        if !packed.is_empty() {
            all.extend((self.unpack)(packed, self.max_bytes).map_err(|error| ParquetError::External(Box::new(error)))?);
        }
        Ok(all)
    }
}

impl PageReader for Pages {
    fn get_next_page(&mut self) -> Result<Option<Page>> {
        let Some(mut page) = self.inner.get_next_page()? else { return Ok(None) };
        match &mut page {
            Page::DataPage { buf, .. } | Page::DictionaryPage { buf, .. } => *buf = self.unpacked(buf, 0)?.into(),
            Page::DataPageV2 { buf, def_levels_byte_len, rep_levels_byte_len, is_compressed, .. } => {
                if *is_compressed {
                    let levels = *def_levels_byte_len as usize + *rep_levels_byte_len as usize;
                    *buf = self.unpacked(buf, levels)?.into();
                }
            }
        }
        Ok(Some(page))
    }

    fn peek_next_page(&mut self) -> Result<Option<PageMetadata>> {
        self.inner.peek_next_page()
    }

    fn skip_next_page(&mut self) -> Result<()> {
        self.inner.skip_next_page()
    }

    fn at_record_boundary(&mut self) -> Result<bool> {
        self.inner.at_record_boundary()
    }
}

impl Iterator for Pages {
    type Item = Result<Page>;

    fn next(&mut self) -> Option<Self::Item> {
        self.get_next_page().transpose()
    }
}
