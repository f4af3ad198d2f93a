//! Reads each run of spaces as one tab, and omits spaces at the ends of lines.

use std::io::{self, Read};

pub(super) struct Spaces<R> {
    inner: R,
    is_on: bool,
    is_open: bool,
    at_start: bool,
    spare: Vec<u8>,
}

impl<R: Read> Spaces<R> {
    pub(super) fn new(inner: R, is_on: bool) -> Self {
        Self { inner, is_on, is_open: false, at_start: true, spare: vec![] }
    }
}

impl<R: Read> Read for Spaces<R> {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        if !self.is_on || out.len() < 2 {
            return self.inner.read(out);
        }
        loop {
            // A pending tab can precede each byte.
            self.spare.resize(out.len() / 2, 0);
            let got = self.inner.read(&mut self.spare)?;
            let mut kept = 0;
            for &byte in &self.spare[..got] {
                match byte {
                    b' ' | b'\t' => self.is_open = !self.at_start,
                    b'\n' => (self.is_open, self.at_start) = (false, true),
                    _ => self.at_start = false,
                }
                if !matches!(byte, b' ' | b'\t') {
                    if std::mem::take(&mut self.is_open) {
                        out[kept] = b'\t';
                        kept += 1;
                    }
                    out[kept] = byte;
                    kept += 1;
                }
            }
            if kept > 0 || got == 0 {
                return Ok(kept);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_of_spaces_become_tabs_wherever_the_chunks_split() {
        for step in 2..9 {
            let mut spaces = Spaces::new(&b"  t  x \t f \n 0 1  2\n"[..], true);
            let mut passed = vec![];
            let mut out = vec![0; step];
            loop {
                match spaces.read(&mut out).expect("text") {
                    0 => break,
                    count => passed.extend_from_slice(&out[..count]),
                }
            }
            assert_eq!(passed, b"t\tx\tf\n0\t1\t2\n", "{step}");
        }
    }
}
