//! How much of a file is taken in, and how long it may pause.

trocar_core::settings! {
    /// Bounds on what is read. Memory stays below about `32 * max_samples` bytes plus the longest row.
    #[derive(Clone, Debug, PartialEq)]
    pub struct Limits in "recording." {
        /// Longest time between two samples; 10 median intervals when not given.
        ///
        /// Interpolating across a longer pause would invent data. See [`Limits::GAP_IN_MEDIANS`].
        max_gap_s: Option<f64> [POSITIVE],
        /// Largest file that is read.
        ///
        /// In bytes; a larger one is refused before anything is read.
        max_bytes: u64 [1..] = 256 << 20,
        /// Most samples that are kept.
        ///
        /// The default is 83 minutes at 1 kHz.
        max_samples: usize [2..] = 5_000_000,
    }
}

impl Limits {
    /// The default longest gap, in median intervals.
    pub const GAP_IN_MEDIANS: f64 = 10.0;

    /// Largest position (m), velocity (m/s) and force (N) that is taken for a needle's: beyond, squares overflow, and a scale is
    /// surely missing.
    pub const MAX_MAGNITUDE: f64 = 1e6;

    /// Bytes in one line at most: a file without line ends is not a table.
    pub const MAX_LINE_BYTES: u64 = 1 << 20;
}
