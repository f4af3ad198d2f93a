//! Recognises damaged data.

/// FNV-1a of words and of the library's version; no protection against an attacker.
pub(crate) struct Digest(u64);

impl Default for Digest {
    fn default() -> Self {
        let mut digest = Self(0xcbf2_9ce4_8422_2325);
        env!("CARGO_PKG_VERSION").bytes().for_each(|byte| digest.add_byte(byte));
        digest
    }
}

impl Digest {
    pub(crate) fn add(&mut self, word: u64) {
        word.to_le_bytes().into_iter().for_each(|byte| self.add_byte(byte));
    }

    pub(crate) fn value(&self) -> u64 {
        self.0
    }

    fn add_byte(&mut self, byte: u8) {
        self.0 = (self.0 ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
    }
}
