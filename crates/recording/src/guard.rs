//! A reader that bounds the size of a text and unifies line ends.

use std::io::{self, ErrorKind, Read};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};

use super::error::{Place, Problem};
use super::{Limits, RecordingError};

/// Passes on every line end (`\r\n`, `\r`, `\n`) as `\n`, and one after the last line, so that the number of `\n` is
/// the line number of an editor. Too many bytes, an overlong line and binary data cause a [`RecordingError`], which
/// [`recover`] extracts.
pub(super) struct Guard<R> {
    inner: R,
    file: Box<str>,
    max_bytes: u64,
    bytes: u64,
    /// From 1, and the number of its bytes.
    line: u64,
    line_bytes: u64,
    after_return: bool,
    ended: bool,
    is_open: Arc<AtomicBool>,
}

impl<R: Read> Guard<R> {
    pub(super) fn new(file: &str, inner: R, max_bytes: u64) -> Self {
        Self {
            inner,
            file: file.into(),
            max_bytes,
            bytes: 0,
            line: 1,
            line_bytes: 0,
            after_return: false,
            ended: false,
            is_open: Arc::default(),
        }
    }

    pub(super) fn is_open(&self) -> Arc<AtomicBool> {
        self.is_open.clone()
    }

    fn refuse(&self, line: Option<u64>, problem: Problem) -> io::Error {
        let place = Place::file(&self.file);
        let place = line.map_or(place.clone(), |line| place.at_line(line));
        io::Error::other(place.error(problem))
    }

    fn unify_line_ends(&mut self, chunk: &mut [u8]) -> usize {
        if !self.after_return && !chunk.contains(&b'\r') {
            return chunk.len();
        }
        let mut kept = 0;
        for from in 0..chunk.len() {
            let byte = chunk[from];
            let second_half = byte == b'\n' && self.after_return;
            self.after_return = byte == b'\r';
            if !second_half {
                chunk[kept] = if byte == b'\r' { b'\n' } else { byte };
                kept += 1;
            }
        }
        kept
    }

    fn count_lines(&mut self, text: &[u8]) {
        self.line += text.iter().filter(|&&byte| byte == b'\n').count() as u64;
        self.line_bytes = match text.iter().rposition(|&byte| byte == b'\n') {
            Some(last) => (text.len() - 1 - last) as u64,
            None => self.line_bytes + text.len() as u64,
        };
    }
}

impl<R: Read> Read for Guard<R> {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        while !self.ended && !out.is_empty() {
            let got = match self.inner.read(out) {
                Ok(got) => got.min(out.len()),
                Err(error) if error.kind() == ErrorKind::Interrupted => continue,
                Err(error) => return Err(error),
            };
            if got == 0 {
                self.ended = true;
                if self.line_bytes == 0 {
                    break;
                }
                self.is_open.store(true, Relaxed);
                out[0] = b'\n';
                return Ok(1);
            }
            self.bytes += got as u64;
            if self.bytes > self.max_bytes {
                let limit = self.max_bytes;
                return Err(self.refuse(None, Problem::TooManyBytes { limit }));
            }
            let kept = self.unify_line_ends(&mut out[..got]);
            let text = &out[..kept];
            if let Some(zero) = text.iter().position(|&byte| byte == 0) {
                self.count_lines(&text[..zero]);
                return Err(self.refuse(Some(self.line), Problem::Binary));
            }
            self.count_lines(text);
            if self.line_bytes > Limits::MAX_LINE_BYTES {
                return Err(self.refuse(Some(self.line), Problem::LineTooLong));
            }
            if kept > 0 {
                return Ok(kept);
            }
        }
        Ok(0)
    }
}

pub(super) fn recover(file: &str, error: io::Error) -> RecordingError {
    match error.downcast::<RecordingError>() {
        Ok(refusal) => refusal,
        Err(error) => Place::file(file).error(Problem::Unreadable(error)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Reads a few bytes at a time, to split every pair of bytes at some step.
    struct Trickle<'a>(&'a [u8], usize);

    impl Read for Trickle<'_> {
        fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
            let count = self.1.min(out.len());
            self.0.read(&mut out[..count])
        }
    }

    fn through(text: &[u8], step: usize) -> io::Result<String> {
        let mut passed = String::new();
        Guard::new("x.csv", Trickle(text, step), 1 << 30).read_to_string(&mut passed)?;
        Ok(passed)
    }

    #[test]
    fn line_ends_become_one_kind_wherever_the_chunks_split() {
        for step in 1..9 {
            let passed = through(b"a\r\nb\rc\n\n\r\n\r\rd", step).expect("text");
            assert_eq!(passed, "a\nb\nc\n\n\n\n\nd\n", "{step}");
        }
        assert_eq!(through(b"", 1).expect("text"), "");
    }

    #[test]
    fn endless_sources_are_cut_off() {
        let refusal = |byte, max_bytes| {
            let mut guard = Guard::new("x.csv", io::repeat(byte), max_bytes);
            let error = io::copy(&mut guard, &mut io::sink()).expect_err("endless");
            recover("x.csv", error).to_string()
        };
        let binary = "x.csv line 1: holds binary data (a zero byte); export it as CSV text in UTF-8";
        assert_eq!(refusal(0, 1 << 30), binary);
        let long = "x.csv line 1: the line is longer than 1048576 bytes; is this a table with one sample per line?";
        assert_eq!(refusal(b'7', 1 << 30), long);
        let many =
            "x.csv: holds more than 2.0 MiB (2097152 bytes); keep fewer rows or columns, or raise recording.max_bytes";
        assert_eq!(refusal(b'\n', 2 << 20), many);
    }

    proptest! {
        #[test]
        fn no_carriage_return_gets_through(text in "[ab\r\n]{0,40}", step in 1_usize..5) {
            let expected = text.replace("\r\n", "\n").replace('\r', "\n");
            let open = !expected.is_empty() && !expected.ends_with('\n');
            let expected = if open { expected + "\n" } else { expected };
            prop_assert_eq!(through(text.as_bytes(), step).expect("text"), expected);
        }
    }
}
