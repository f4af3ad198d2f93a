use super::sequence::Arrival;
use crate::lane::Stored;

/// Samples since the controller was created.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Counters {
    /// With a faulty channel, stale samples included.
    pub bad: u64,
    /// With the number of the newest sample.
    pub repeated: u64,
    /// With a lower number.
    pub late: u64,
    /// Interpolated.
    pub bridged: u64,
    /// Gaps too long to bridge, and counters set back.
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
