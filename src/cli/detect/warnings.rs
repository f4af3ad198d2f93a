//! Warnings on standard error, with a limited rate.

use std::io::Write;
use std::time::{Duration, Instant};

use trocar_sim::detect::TimestampAnomaly;

/// Maximum number of warnings per second.
const MAX_PER_SECOND: u32 = 5;

/// Minimum sampling rate without a warning, in Hz. With the defaults of `trocar calibrate`, the force of the slowest rupture falls
/// by half in 30 ms, which are three samples at this rate.
const MIN_RATE_HZ: f64 = 100.0;

/// Prints a limited number of warnings per second, and counts the others.
pub(super) struct Warnings {
    quiet: bool,
    second_start: Option<Instant>,
    printed: u32,
    suppressed: u64,
}

impl Warnings {
    pub(super) fn new(quiet: bool) -> Self {
        Self { quiet, second_start: None, printed: 0, suppressed: 0 }
    }

    /// Prints a message without a rate limit.
    pub(super) fn note(&self, text: &str) {
        if !self.quiet {
            // Standard error can be closed; the stream continues.
            let _ = writeln!(anstream::stderr(), "{text}");
        }
    }

    /// Prints a warning, unless this second has the maximum number of warnings.
    pub(super) fn warn(&mut self, text: impl FnOnce() -> String) {
        if self.quiet {
            return;
        }
        let now = Instant::now();
        if self.second_start.is_none_or(|start| now.duration_since(start) >= Duration::from_secs(1)) {
            self.second_start = Some(now);
            self.printed = 0;
            self.flush();
        }
        if self.printed < MAX_PER_SECOND {
            self.printed += 1;
            self.note(&format!("warning: {}", text()));
        } else {
            self.suppressed += 1;
        }
    }

    /// Prints the number of suppressed warnings, if any.
    pub(super) fn flush(&mut self) {
        let suppressed = std::mem::take(&mut self.suppressed);
        if suppressed > 0 {
            self.note(&format!("warning: {suppressed} more warnings suppressed"));
        }
    }
}

/// Returns a warning if samples `interval_s` (s) apart are too far apart to show a rupture, otherwise `None`.
pub(super) fn low_rate_warning(interval_s: f64) -> Option<String> {
    let rate_hz = 1.0 / interval_s;
    // A tolerance of 1 % for the measured rate.
    (rate_hz < 0.99 * MIN_RATE_HZ).then(|| {
        format!(
            "the sampling rate is {rate_hz:.3} Hz, below {MIN_RATE_HZ} Hz: a rupture lasts about 30 ms and can fall between two \
             samples, and the defaults of estimator and detector are for intervals of 0.5 to 2 ms"
        )
    })
}

/// Returns a timestamp anomaly as text.
pub(super) fn text(anomaly: &TimestampAnomaly) -> String {
    match anomaly {
        TimestampAnomaly::NotLater { last_s, time_s } => {
            format!("time {time_s} s is not after the time of the previous sample, {last_s} s; the row is skipped")
        }
        TimestampAnomaly::SetBack { last_s, time_s } => {
            format!("the clock was set back from {last_s} s to {time_s} s; the detection restarts")
        }
        TimestampAnomaly::Gap { last_s, time_s } => {
            format!("no sample from {last_s} s to {time_s} s; the detection restarts")
        }
    }
}
