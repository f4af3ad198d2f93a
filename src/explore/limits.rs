/// In bytes. A state has a few hundred.
pub const MAX_MESSAGE_BYTES: usize = 16 << 10;

/// Two minutes at 1 kHz.
pub const MAX_TICKS: u64 = 120_000;

pub const MAX_POINTS: usize = 4000;

/// Per axis.
pub const MAP_POINTS: usize = 48;

pub const MAX_KEYS: usize = 64;

pub const MAX_NUMBERS: usize = 64;
