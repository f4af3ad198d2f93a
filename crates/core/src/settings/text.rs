/// A sentence of `LEN` bytes.
pub struct Sentence<const LEN: usize>([u8; LEN]);

impl<const LEN: usize> Sentence<LEN> {
    /// The text.
    #[must_use]
    pub const fn as_str(&self) -> &str {
        match core::str::from_utf8(&self.0) {
            Ok(text) => text,
            Err(_) => panic!("documentation is UTF-8"),
        }
    }
}

/// Length of [`sentence`] in bytes.
#[must_use]
pub const fn sentence_len(lines: &[&str]) -> usize {
    let (mut len, mut line) = (0, 0);
    while line < lines.len() && !lines[line].is_empty() {
        // Each line of a doc comment begins with a space.
        len += lines[line].len();
        line += 1;
    }
    len.saturating_sub(1)
}

/// The first paragraph of a doc comment, joined by spaces.
#[must_use]
pub const fn sentence<const LEN: usize>(lines: &[&str]) -> Sentence<LEN> {
    let mut bytes = [0; LEN];
    let (mut filled, mut line, mut byte) = (0, 0, 1);
    while filled < LEN {
        let text = lines[line].as_bytes();
        while byte < text.len() {
            bytes[filled] = text[byte];
            (filled, byte) = (filled + 1, byte + 1);
        }
        (line, byte) = (line + 1, 0);
    }
    Sentence(bytes)
}
