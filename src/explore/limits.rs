//! Limits of a page, so that no client can block other clients or the machine.

use std::time::Duration;

pub const MAX_SESSIONS: usize = 16;

/// Maximum number of connections that are not yet a page. Beyond it, the server closes the oldest one.
pub const MAX_WAITING: usize = 128;

/// Maximum number of connections that wait to be accepted; the system may allow fewer.
pub const MAX_UNACCEPTED: u32 = 4096;

pub const HEAD_TIMEOUT: Duration = Duration::from_secs(3);

pub const REQUEST_TIMEOUT: Duration = Duration::from_secs(10);

/// Maximum size of a message from a page, in bytes. A state has a few hundred bytes.
pub const MAX_MESSAGE_BYTES: usize = 16 << 10;

/// Maximum burst of messages from a page, and maximum rate of messages per second.
pub const MESSAGES: (f64, f64) = (600.0, 300.0);

pub const SEND_TIMEOUT: Duration = Duration::from_secs(5);

pub const PING_INTERVAL: Duration = Duration::from_secs(10);
/// Maximum time without a message or a pong from a page.
pub const MAX_SILENCE: Duration = Duration::from_secs(35);

/// Maximum number of ticks of a run: two minutes at 1 kHz.
pub const MAX_TICKS: u64 = 120_000;

/// Maximum number of stopped insertions per page whose threads still run.
pub const MAX_ENDING: usize = 8;

/// Maximum number of points per line.
pub const MAX_POINTS: usize = 4000;

/// Number of points of a stability map per axis.
pub const MAP_POINTS: usize = 48;

pub const MAX_KEYS: usize = 64;

pub const MAX_NUMBERS: usize = 64;
