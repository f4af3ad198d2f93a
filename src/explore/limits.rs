//! How much a page may ask for, so that no client can stall another one or the machine.

use std::time::Duration;

/// Pages that are open at a time.
pub const MAX_SESSIONS: usize = 16;

/// Connections that have not become a page yet; beyond, the oldest one goes.
pub const MAX_WAITING: usize = 128;

/// How long a request's head may take to arrive.
pub const HEAD: Duration = Duration::from_secs(3);

/// How long one request may take from the first byte to the last.
pub const REQUEST: Duration = Duration::from_secs(10);

/// Bytes of one message of a page; a state has a few hundred.
pub const MAX_MESSAGE_BYTES: usize = 16 << 10;

/// Messages of a page in one go, and how many more each second.
pub const MESSAGES: (f64, f64) = (600.0, 300.0);

/// How long a page may take to read what it asked for.
pub const STALLED: Duration = Duration::from_secs(5);

/// How often a page is asked whether it is there, and how long it may be silent.
pub const PING: Duration = Duration::from_secs(10);
/// See [`PING`].
pub const SILENT: Duration = Duration::from_secs(35);

/// Ticks of a run that a page may ask for: at 1 kHz two minutes.
pub const MAX_TICKS: u64 = 120_000;

/// Insertions by hand of a page that have been ended and have not gone yet.
pub const MAX_ENDING: usize = 8;

/// Points of a line on the page.
pub const MAX_POINTS: usize = 4000;

/// Points of a stability map along either axis.
pub const MAP_POINTS: usize = 48;

/// How many keys a page may change.
pub const MAX_KEYS: usize = 64;

/// How many numbers a list may have that a page gives.
pub const MAX_NUMBERS: usize = 64;
