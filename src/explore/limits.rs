//! Limits of the requests of a page.

/// Maximum size of a message from a page, in bytes. A state has a few hundred bytes.
pub const MAX_MESSAGE_BYTES: usize = 16 << 10;

/// Maximum number of ticks of a run: two minutes at 1 kHz.
pub const MAX_TICKS: u64 = 120_000;

/// Maximum number of points per line.
pub const MAX_POINTS: usize = 4000;

/// Number of points of a stability map per axis.
pub const MAP_POINTS: usize = 48;

pub const MAX_KEYS: usize = 64;

pub const MAX_NUMBERS: usize = 64;
