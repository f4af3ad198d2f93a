//! How much of a file is taken in, and how long it may pause.

/// Bounds on what is read. Memory stays below about `32 * max_samples` bytes plus the longest row.
#[derive(Clone, Debug, PartialEq)]
pub struct Limits {
    /// Bytes read at most; a file larger than this is refused before anything is read. Default: 256 MiB.
    pub max_bytes: u64,
    /// Rows kept at most. Default: 5 million, 83 minutes at 1 kHz.
    pub max_samples: usize,
    /// The longest time between two samples in s; interpolating across a longer pause would invent data.
    /// Default `None`: [`Limits::GAP_IN_MEDIANS`] times the recording's median interval.
    pub max_gap_s: Option<f64>,
}

impl Limits {
    /// The default.
    pub const DEFAULT: Self = Self { max_bytes: 256 << 20, max_samples: 5_000_000, max_gap_s: None };

    /// The default longest gap, in median intervals.
    pub const GAP_IN_MEDIANS: f64 = 10.0;

    /// Largest position (m), velocity (m/s) and force (N) that is taken for a needle's: beyond, squares overflow, and a scale is
    /// surely missing.
    pub const MAX_MAGNITUDE: f64 = 1e6;

    /// Bytes in one line at most: a file without line ends is not a table.
    pub const MAX_LINE_BYTES: u64 = 1 << 20;
}

impl Default for Limits {
    fn default() -> Self {
        Self::DEFAULT
    }
}
