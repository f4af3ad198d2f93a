//! Converts UTF-16 with a byte order mark to UTF-8; other text passes unchanged.

use std::io::{self, Read};

const CHUNK_BYTES: usize = 16 << 10;

pub(super) fn is_marked(head: &[u8]) -> bool {
    head.starts_with(b"\xff\xfe") || head.starts_with(b"\xfe\xff")
}

#[derive(Debug, Clone, Copy)]
enum Encoding {
    Unknown,
    Bytes,
    Utf16(fn([u8; 2]) -> u16),
}

pub(super) struct Utf8<R> {
    inner: R,
    encoding: Encoding,
    ready: Vec<u8>,
    next: usize,
    open: Vec<u8>,
}

impl<R: Read> Utf8<R> {
    pub(super) fn new(inner: R) -> Self {
        Self { inner, encoding: Encoding::Unknown, ready: vec![], next: 0, open: vec![] }
    }

    fn begin(&mut self) -> io::Result<()> {
        let mut mark = vec![];
        self.inner.by_ref().take(2).read_to_end(&mut mark)?;
        self.encoding = match mark.as_slice() {
            b"\xff\xfe" => Encoding::Utf16(u16::from_le_bytes),
            b"\xfe\xff" => Encoding::Utf16(u16::from_be_bytes),
            _ => {
                self.ready = mark;
                Encoding::Bytes
            }
        };
        Ok(())
    }

    fn convert(&mut self, unit: fn([u8; 2]) -> u16) -> io::Result<()> {
        (self.ready, self.next) = (vec![], 0);
        while self.ready.is_empty() {
            let before = self.open.len();
            self.inner.by_ref().take(CHUNK_BYTES as u64).read_to_end(&mut self.open)?;
            let is_end = self.open.len() == before;
            let mut units: Vec<u16> = self.open.chunks_exact(2).map(|pair| unit([pair[0], pair[1]])).collect();
            // The first half of a surrogate pair waits for the second.
            if !is_end && units.last().is_some_and(|last| (0xd800..0xdc00).contains(last)) {
                units.pop();
            }
            if units.is_empty() && is_end {
                break;
            }
            self.open.drain(..2 * units.len());
            self.ready = String::from_utf16_lossy(&units).into_bytes();
        }
        Ok(())
    }
}

impl<R: Read> Read for Utf8<R> {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        if matches!(self.encoding, Encoding::Unknown) {
            self.begin()?;
        }
        if self.next == self.ready.len() {
            match self.encoding {
                Encoding::Utf16(unit) => self.convert(unit)?,
                _ => return self.inner.read(out),
            }
        }
        let count = out.len().min(self.ready.len() - self.next);
        out[..count].copy_from_slice(&self.ready[self.next..self.next + count]);
        self.next += count;
        Ok(count)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn through(bytes: &[u8]) -> String {
        let mut text = String::new();
        Utf8::new(bytes).read_to_string(&mut text).expect("text");
        text
    }

    #[test]
    fn utf16_becomes_utf8() {
        let text = "t;µ;𝄞\n".repeat(5000);
        let little: Vec<u8> = [0xfeff].into_iter().chain(text.encode_utf16()).flat_map(u16::to_le_bytes).collect();
        let big: Vec<u8> = [0xfeff].into_iter().chain(text.encode_utf16()).flat_map(u16::to_be_bytes).collect();
        assert_eq!(through(&little), text);
        assert_eq!(through(&big), text);
        assert_eq!(through(&little[..little.len() - 1]), text[..text.len() - 1], "half a character is left out");
        assert_eq!(through(b"t,x"), "t,x");
        assert_eq!(through(b"t"), "t");
        assert_eq!(through(b""), "");
    }
}
