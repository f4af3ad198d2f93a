trocar_core::settings! {
    /// Limits on reading. The memory for text stays below about `32 * max_samples` bytes plus the longest row.
    #[derive(Clone, Debug, PartialEq)]
    pub struct Limits in "recording." {
        /// Maximum time between two samples; 10 median intervals when not given.
        ///
        /// Interpolation across a longer gap would invent data. See [`Limits::GAP_IN_MEDIANS`].
        max_gap_s: Option<f64> [POSITIVE],
        /// Maximum size of a file.
        ///
        /// In bytes; a larger file is rejected before anything is read. Its decompressed content, its values and the names
        /// of its signals may have twice as many.
        max_bytes: u64 [1..] = 256 << 20,
        /// Maximum number of samples.
        ///
        /// The default is 83 minutes at 1 kHz.
        max_samples: usize [2..] = 5_000_000,
        /// Number of lines before the table in a text; a preamble is also found without it.
        skip_lines: u64 [0..] = 0,
        /// Samples per second of a file without a time; its column of time is then not read.
        rate_hz: Option<f64> [POSITIVE],
    }
}

impl Limits {
    /// In median intervals.
    pub const GAP_IN_MEDIANS: f64 = 10.0;

    /// Largest plausible value in SI units. Larger numbers overflow when squared, and indicate a missing scale.
    pub const MAX_MAGNITUDE: f64 = 1e6;

    pub(super) fn of_table(&self) -> Self {
        Self { skip_lines: 0, rate_hz: None, ..self.clone() }
    }

    /// In bytes. A file without line ends is not a table.
    pub const MAX_LINE_BYTES: u64 = 1 << 20;
}
