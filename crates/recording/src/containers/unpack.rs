//! Decompresses the blocks of other formats, within the budget of the file.

use std::io;

use crate::budget::Budget;

/// A function that decompresses a block.
pub(super) type Unpack = fn(&[u8], &Budget) -> io::Result<Vec<u8>>;

/// The bytes of a block that is compressed by Zstandard, whose checksum is checked.
pub(super) fn zstd(block: &[u8], budget: &Budget) -> io::Result<Vec<u8>> {
    let mut decoder = ruzstd::decoding::StreamingDecoder::new(block).map_err(io::Error::other)?;
    let bytes = budget.read(&mut decoder)?;
    let (stated, computed) = (decoder.decoder.get_checksum_from_data(), decoder.decoder.get_calculated_checksum());
    if stated.is_some() && stated != computed {
        return Err(io::Error::other("the checksum of a block of Zstandard is wrong"));
    }
    Ok(bytes)
}

/// The bytes of a frame of LZ4.
pub(super) fn lz4(frame: &[u8], budget: &Budget) -> io::Result<Vec<u8>> {
    budget.read(lz4_flex::frame::FrameDecoder::new(frame))
}

/// The bytes of a stream of Brotli.
pub(super) fn brotli(stream: &[u8], budget: &Budget) -> io::Result<Vec<u8>> {
    const BUFFER_BYTES: usize = 16 << 10;
    budget.read(brotli_decompressor::Decompressor::new(stream, BUFFER_BYTES))
}

/// The bytes of a stream of gzip, whose checksum is checked.
pub(super) fn gzip(stream: &[u8], budget: &Budget) -> io::Result<Vec<u8>> {
    budget.read(flate2::read::MultiGzDecoder::new(stream))
}

/// The bytes of a block of Snappy, which states its size first.
pub(super) fn snappy(block: &[u8], budget: &Budget) -> io::Result<Vec<u8>> {
    let size = snap::raw::decompress_len(block).map_err(io::Error::other)?;
    // Three bytes of a block copy at most 64 bytes.
    if size > block.len().saturating_mul(64) {
        return Err(io::Error::other("a block of Snappy states a wrong size"));
    }
    charge(budget, size)?;
    snap::raw::Decoder::new().decompress_vec(block).map_err(io::Error::other)
}

/// The bytes of a block of LZ4 without a frame, which does not state its size.
pub(super) fn lz4_block(block: &[u8], budget: &Budget) -> io::Result<Vec<u8>> {
    // A byte of a block repeats at most 255 bytes.
    let most = block.len().saturating_mul(256).min(budget.left());
    let bytes = lz4_flex::block::decompress(block, most).map_err(io::Error::other)?;
    charge(budget, bytes.len())?;
    Ok(bytes)
}

/// The bytes of blocks of LZ4 as Hadoop writes them, each after its size and its compressed size; or of a frame, or of a
/// block alone, as older programs wrote them.
pub(super) fn lz4_hadoop(stream: &[u8], budget: &Budget) -> io::Result<Vec<u8>> {
    if let Ok(bytes) = lz4(stream, budget) {
        return Ok(bytes);
    }
    let mut bytes = vec![];
    let mut rest = stream;
    while !rest.is_empty() {
        let size = |at: usize| {
            let bytes = rest.get(at..)?.first_chunk()?;
            usize::try_from(u32::from_be_bytes(*bytes)).ok()
        };
        let block = size(4).and_then(|packed| rest.get(8..8_usize.checked_add(packed)?));
        let (Some(plain), Some(block)) = (size(0), block) else { return lz4_block(stream, budget) };
        if plain > block.len().saturating_mul(256) {
            return lz4_block(stream, budget);
        }
        charge(budget, plain)?;
        bytes.extend(lz4_flex::block::decompress(block, plain).map_err(io::Error::other)?);
        rest = &rest[8 + block.len()..];
    }
    Ok(bytes)
}

fn charge(budget: &Budget, bytes: usize) -> io::Result<()> {
    let charged = budget.hold("decompressed content", bytes);
    charged.and_then(|()| budget.work("decompressed content", bytes)).map_err(io::Error::other)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Limits;
    use std::io::Write;

    fn budget(max_memory_bytes: u64) -> Budget {
        Budget::new(&Limits { max_memory_bytes, ..Limits::default() })
    }

    #[test]
    fn a_block_that_grows_beyond_the_budget_is_refused() {
        let mut packed = lz4_flex::frame::FrameEncoder::new(vec![]);
        packed.write_all(&[0; 100_000]).expect("packed");
        let lz4_frame = packed.finish().expect("packed");
        let block = lz4_flex::block::compress(&[0; 100_000]);
        let snapped = snap::raw::Encoder::new().compress_vec(&[0; 100_000]).expect("packed");
        let mut zipped = flate2::write::GzEncoder::new(vec![], flate2::Compression::best());
        zipped.write_all(&[0; 100_000]).expect("packed");
        let zipped = zipped.finish().expect("packed");
        let size = |bytes: usize| u32::try_from(bytes).expect("small").to_be_bytes();
        let hadoop = [&size(100_000)[..], &size(block.len()), &block].concat();
        let cases: [(Unpack, &[u8]); 6] = [
            (lz4, &lz4_frame),
            (lz4_block, &block),
            (snappy, &snapped),
            (gzip, &zipped),
            (lz4_hadoop, &hadoop),
            (lz4_hadoop, &lz4_frame),
        ];
        for (index, (unpack, packed)) in cases.into_iter().enumerate() {
            assert!(packed.len() < 6000, "{index}");
            assert_eq!(unpack(packed, &budget(100_000)).expect("within the limit").len(), 100_000, "{index}");
            assert!(unpack(packed, &budget(99_999)).is_err(), "{index}");
        }
        for refused in [zstd, brotli, lz4, snappy, gzip, lz4_block] {
            assert!(refused(b"\xff\xff\xff no frame", &budget(1 << 20)).is_err());
        }
    }
}
