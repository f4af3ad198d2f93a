//! Counts of bad, stale and lost samples.

use super::sequence::Arrival;
use crate::lane::Stored;

/// Counts of samples since the controller was created.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Counters {
    /// Samples with a faulty channel, stale samples included.
    pub bad: u64,
    /// Samples with the number of the newest sample.
    pub repeated: u64,
    /// Samples with a number below the newest one.
    pub late: u64,
    /// Missing samples that were interpolated.
    pub bridged: u64,
    /// Gaps too long to be bridged, and counters that were set back. The detector was blind.
    pub gaps: u64,
}

impl Counters {
    pub(super) fn note(&mut self, arrival: Arrival) {
        match arrival {
            Arrival::New | Arrival::Restarted => {}
            Arrival::Repeated => self.repeated += 1,
            Arrival::Late => self.late += 1,
        }
    }
}

impl Stored for Counters {
    fn numbers(&mut self, with: &mut dyn FnMut(&mut u64)) {
        let Self { bad, repeated, late, bridged, gaps } = self;
        for count in [bad, repeated, late, bridged, gaps] {
            count.numbers(with);
        }
    }
}
