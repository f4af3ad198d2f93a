//! The bytes of a packet.
//!
//! ```text
//! 0    magic "TRCR"
//! 4    version
//! 5    kind
//! 6    side of the sender: 0 master, 1 slave
//! 7    0
//! 8    number, ascending per sender
//! 16   tick
//! 24   time of sending in ns since tick 0
//! 32   body, 96 bytes
//! 128  authentication code, 16 bytes
//! ```
//! Numbers are little-endian. All kinds have the same length, so that no answer is longer than its request.

pub const PACKET_BYTES: usize = SIGNED_BYTES + CODE_BYTES;
pub(super) const SIGNED_BYTES: usize = 128;
pub(super) const CODE_BYTES: usize = 16;
pub(super) const BODY_BYTES: usize = SIGNED_BYTES - BODY;

const MAGIC: &[u8; 4] = b"TRCR";
const VERSION: u8 = 1;
const NUMBER: usize = 8;
const TICK: usize = 16;
const SENT: usize = 24;
const BODY: usize = 32;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Role {
    Master,
    Slave,
}

impl Role {
    pub fn word(self) -> &'static str {
        match self {
            Self::Master => "master",
            Self::Slave => "slave",
        }
    }

    pub fn other(self) -> Self {
        match self {
            Self::Master => Self::Slave,
            Self::Slave => Self::Master,
        }
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    Hello,
    Reply,
    Start,
    Ready,
    Message,
}

impl Kind {
    const ALL: [Self; 5] = [Self::Hello, Self::Reply, Self::Start, Self::Ready, Self::Message];
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Packet {
    pub(super) kind: Kind,
    pub(super) from: Role,
    pub(super) number: u64,
    pub(super) tick: u64,
    pub(super) sent_ns: i64,
    pub(super) body: [u8; BODY_BYTES],
}

impl Packet {
    pub(super) fn bytes(&self) -> [u8; PACKET_BYTES] {
        let mut bytes = [0; PACKET_BYTES];
        bytes[..4].copy_from_slice(MAGIC);
        bytes[4] = VERSION;
        bytes[5] = self.kind as u8;
        bytes[6] = self.from as u8;
        bytes[NUMBER..TICK].copy_from_slice(&self.number.to_le_bytes());
        bytes[TICK..SENT].copy_from_slice(&self.tick.to_le_bytes());
        bytes[SENT..BODY].copy_from_slice(&self.sent_ns.to_le_bytes());
        bytes[BODY..SIGNED_BYTES].copy_from_slice(&self.body);
        bytes
    }

    pub(super) fn read(bytes: &[u8]) -> Option<Self> {
        let bytes: &[u8; PACKET_BYTES] = bytes.try_into().ok()?;
        if bytes[..4] != *MAGIC || bytes[4] != VERSION || bytes[7] != 0 {
            return None;
        }
        let kind = *Kind::ALL.get(usize::from(bytes[5]))?;
        let from = *[Role::Master, Role::Slave].get(usize::from(bytes[6]))?;
        let mut body = [0; BODY_BYTES];
        body.copy_from_slice(&bytes[BODY..SIGNED_BYTES]);
        let sent_ns = word(bytes, SENT).cast_signed();
        Some(Self { kind, from, number: word(bytes, NUMBER), tick: word(bytes, TICK), sent_ns, body })
    }
}

/// The number at an offset; 0 beyond the end.
pub(super) fn word(bytes: &[u8], at: usize) -> u64 {
    bytes.get(at..).and_then(|rest| rest.first_chunk()).map_or(0, |bytes| u64::from_le_bytes(*bytes))
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn a_packet_is_read_as_it_was_written(
            kind in 0..Kind::ALL.len(), number: u64, tick: u64, sent_ns: i64, filling: u8, is_master: bool,
        ) {
            let from = if is_master { Role::Master } else { Role::Slave };
            let packet = Packet { kind: Kind::ALL[kind], from, number, tick, sent_ns, body: [filling; BODY_BYTES] };
            prop_assert_eq!(Packet::read(&packet.bytes()), Some(packet));
        }

        #[test]
        fn other_bytes_are_no_packet(bytes in prop::collection::vec(any::<u8>(), 0..300)) {
            prop_assert_eq!(Packet::read(&bytes), None);
        }
    }

    #[test]
    fn every_byte_of_the_header_matters() {
        let packet =
            Packet { kind: Kind::Message, from: Role::Slave, number: 1, tick: 2, sent_ns: -3, body: [4; BODY_BYTES] };
        for place in 0..SIGNED_BYTES {
            let mut bytes = packet.bytes();
            bytes[place] ^= 0x80;
            assert_ne!(Packet::read(&bytes), Some(packet), "{place}");
        }
    }
}
