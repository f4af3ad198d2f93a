#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Counters {
    pub sent: u64,
    pub received: u64,
    /// Messages received after a later one; they are not used.
    pub overtaken: u64,
    /// Packets with a wrong length, version or kind, or with a value that is not finite.
    pub malformed: u64,
    /// Packets with a wrong authentication code, of another session, or of this side.
    pub foreign: u64,
    /// Packets with a repeated number, or one that is too old to check.
    pub replayed: u64,
    pub out_of_range: u64,
}

impl Counters {
    pub fn dropped(&self) -> u64 {
        self.malformed + self.foreign + self.replayed + self.out_of_range
    }
}
