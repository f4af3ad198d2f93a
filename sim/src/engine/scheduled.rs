//! Alarms at known ticks, whatever the detector says.

use std::sync::Arc;

/// The ticks at which the supervisor is alarmed, in every lane; it takes such an alarm where it would take one of the
/// detector's. Looked at only where there are any, or where something else already takes the tick off its straight way.
#[derive(Debug, Clone)]
pub struct ScheduledAlarms {
    ticks: Arc<[u64]>,
    index: usize,
    /// The next of them; beyond every run where there is none.
    next: u64,
}

impl ScheduledAlarms {
    /// Alarms at ticks that ascend.
    #[must_use]
    pub fn new(ticks: Arc<[u64]>) -> Self {
        Self { next: ticks.first().copied().unwrap_or(u64::MAX), ticks, index: 0 }
    }

    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.ticks.is_empty()
    }

    /// Those of engines side by side, which have to be the same, as an alarm is one in every lane.
    pub(super) fn in_all<const N: usize>(&self, all: [&Self; N]) -> Option<Self> {
        all.iter().all(|other| other.ticks == self.ticks && other.index == self.index).then(|| self.clone())
    }

    /// Whether there is one at this tick, later than all that were asked for before.
    #[inline(always)]
    pub(super) fn is_due(&mut self, tick: u64) -> bool {
        let is_due = tick == self.next;
        if is_due {
            self.advance();
        }
        is_due
    }

    #[cold]
    #[inline(never)]
    fn advance(&mut self) {
        self.index += 1;
        self.next = self.ticks.get(self.index).copied().unwrap_or(u64::MAX);
    }
}
