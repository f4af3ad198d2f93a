//! Decompresses the blocks of other formats, up to a limit.

use std::io::{self, Read};

/// The bytes of a block that is compressed by Zstandard.
pub(super) fn zstd(block: &[u8], limit: u64) -> io::Result<Vec<u8>> {
    let decoder = ruzstd::decoding::StreamingDecoder::new(block).map_err(io::Error::other)?;
    bounded(decoder, limit)
}

/// The bytes of a frame of LZ4.
pub(super) fn lz4(frame: &[u8], limit: u64) -> io::Result<Vec<u8>> {
    bounded(lz4_flex::frame::FrameDecoder::new(frame), limit)
}

/// The bytes of a stream of Brotli.
pub(super) fn brotli(stream: &[u8], limit: u64) -> io::Result<Vec<u8>> {
    const BUFFER_BYTES: usize = 16 << 10;
    bounded(brotli_decompressor::Decompressor::new(stream, BUFFER_BYTES), limit)
}

/// Reads everything, or fails after `limit` bytes.
pub(super) fn bounded(reader: impl Read, limit: u64) -> io::Result<Vec<u8>> {
    let mut bytes = vec![];
    reader.take(limit.saturating_add(1)).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > limit {
        return Err(io::Error::other(format!("it decompresses to more than {limit} bytes")));
    }
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Write;

    #[test]
    fn a_block_that_grows_beyond_the_limit_is_refused() {
        let mut packed = lz4_flex::frame::FrameEncoder::new(vec![]);
        packed.write_all(&[0; 100_000]).expect("packed");
        let packed = packed.finish().expect("packed");
        assert!(packed.len() < 2000);
        assert_eq!(lz4(&packed, 100_000).expect("within the limit").len(), 100_000);
        assert!(lz4(&packed, 99_999).expect_err("refused").to_string().contains("more than 99999 bytes"));
        for refused in [zstd(b"no frame", 10), brotli(b"\xff\xff\xff", 10), lz4(b"no frame", 10)] {
            assert!(refused.is_err());
        }
    }
}
