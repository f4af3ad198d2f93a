use std::io::Write;
use std::time::{Duration, Instant};

use trocar_detect::TimestampAnomaly;

const MAX_PER_SECOND: u32 = 5;

/// Counts the suppressed warnings.
pub(super) struct LiveWarnings {
    quiet: bool,
    second_start: Option<Instant>,
    printed: u32,
    suppressed: u64,
}

impl LiveWarnings {
    pub(super) fn new(quiet: bool) -> Self {
        Self { quiet, second_start: None, printed: 0, suppressed: 0 }
    }

    /// Prints without a rate limit.
    pub(super) fn note(&self, text: &str) {
        if !self.quiet {
            // The stream continues without standard error.
            let _ = writeln!(anstream::stderr(), "{text}");
        }
    }

    /// Prints at most the maximum number per second.
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

    pub(super) fn flush(&mut self) {
        let suppressed = std::mem::take(&mut self.suppressed);
        if suppressed > 0 {
            self.note(&format!("warning: {suppressed} more warnings suppressed"));
        }
    }
}

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
