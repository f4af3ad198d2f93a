//! How many packets came and went.

/// Numbers of packets and messages of one end.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Counters {
    /// Messages sent.
    pub sent: u64,
    /// Messages received.
    pub received: u64,
    /// Messages received after a later one: they are not used.
    pub overtaken: u64,
    /// Packets that are none of this protocol: wrong length, version or kind, or a value that is not a finite number.
    pub malformed: u64,
    /// Packets with a wrong authentication code, of another session, or of one's own side.
    pub foreign: u64,
    /// Packets whose number was used before, or is too old to tell.
    pub replayed: u64,
    /// Messages of a tick beyond the run, or too far ahead.
    pub out_of_range: u64,
}

impl Counters {
    /// The packets that had no effect but on a counter.
    #[must_use]
    pub fn dropped(&self) -> u64 {
        self.malformed + self.foreign + self.replayed + self.out_of_range
    }
}
