//! Warnings on standard error that a bad stream cannot flood.

use std::io::Write;
use std::time::{Duration, Instant};

use trocar_sim::detect::TimestampAnomaly;

/// Warnings a second at most.
const MAX_PER_SECOND: u32 = 5;

/// The lowest rate of samples that is not warned of, in Hz. Chosen here: the slowest rupture that `trocar calibrate` looks for
/// unless told otherwise takes half of the force in 30 ms, which are three samples then.
const MIN_RATE_HZ: f64 = 100.0;

/// Writes warnings, a few each second; those between are counted.
pub(super) struct Warnings {
    quiet: bool,
    since: Option<Instant>,
    shown: u32,
    held_back: u64,
}

impl Warnings {
    pub(super) fn new(quiet: bool) -> Self {
        Self { quiet, since: None, shown: 0, held_back: 0 }
    }

    /// Says something that is not held back.
    pub(super) fn note(&self, text: &str) {
        if !self.quiet {
            // Nobody may listen there; the stream goes on.
            let _ = writeln!(anstream::stderr(), "{text}");
        }
    }

    /// Warns, unless there were many warnings in this second.
    pub(super) fn warn(&mut self, text: impl FnOnce() -> String) {
        if self.quiet {
            return;
        }
        let now = Instant::now();
        if self.since.is_none_or(|since| now.duration_since(since) >= Duration::from_secs(1)) {
            self.since = Some(now);
            self.shown = 0;
            self.flush();
        }
        if self.shown < MAX_PER_SECOND {
            self.shown += 1;
            self.note(&format!("warning: {}", text()));
        } else {
            self.held_back += 1;
        }
    }

    /// Says how many warnings were held back, if any.
    pub(super) fn flush(&mut self) {
        let held_back = std::mem::take(&mut self.held_back);
        if held_back > 0 {
            self.note(&format!("warning: {held_back} more like these"));
        }
    }
}

/// What is to be said of samples `interval_s` (s) apart; nothing where they are close enough to show a rupture.
pub(super) fn too_far_apart(interval_s: f64) -> Option<String> {
    let rate_hz = 1.0 / interval_s;
    // A rate that is right to 1 % is that rate.
    (rate_hz < 0.99 * MIN_RATE_HZ).then(|| {
        format!(
            "{rate_hz:.3} samples a second, below {MIN_RATE_HZ}: a rupture takes some 30 ms and falls between them, and \
             estimator and detector count samples, with defaults for 0.5 to 2 ms"
        )
    })
}

/// An oddity in words.
pub(super) fn words(odd: &TimestampAnomaly) -> String {
    match odd {
        TimestampAnomaly::NotLater { last_s, time_s } => {
            format!("time {time_s} s does not come after the last sample's, {last_s} s; the row is skipped")
        }
        TimestampAnomaly::SetBack { last_s, time_s } => {
            format!("the clock was set back from {last_s} s to {time_s} s; the detection begins anew")
        }
        TimestampAnomaly::Gap { last_s, time_s } => {
            format!("no sample from {last_s} s to {time_s} s; the detection begins anew")
        }
    }
}
