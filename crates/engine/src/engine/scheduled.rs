use std::sync::Arc;

use trocar_core::detector::{Decision, Detector, DetectorInput};
use trocar_core::lane::{Gather, LANES, Lane, Mask, of_each};

#[derive(Debug, Clone)]
pub struct ScheduledAlarms<D> {
    detector: D,
    ticks: Arc<[u64]>,
    tick: u64,
    index: usize,
    /// `u64::MAX` after the last.
    next: u64,
}

impl<D> ScheduledAlarms<D> {
    pub fn new(detector: D, ticks: Arc<[u64]>) -> Self {
        Self { detector, tick: 0, next: ticks.first().copied().unwrap_or(u64::MAX), ticks, index: 0 }
    }

    #[cold]
    fn advance(&mut self) {
        self.index += 1;
        self.next = self.ticks.get(self.index).copied().unwrap_or(u64::MAX);
    }
}

impl<L: Lane, D: Detector<L>> Detector<L> for ScheduledAlarms<D> {
    #[inline(always)]
    fn update(&mut self, input: &DetectorInput<L>) -> Decision<L> {
        let mut decision = self.detector.update(input);
        if self.tick == self.next {
            self.advance();
            decision.alarm = L::Mask::splat(true);
        }
        self.tick += 1;
        decision
    }
}

impl<D: Gather> Gather for ScheduledAlarms<D> {
    type Of<L: Lane> = ScheduledAlarms<D::Of<L>>;

    /// A scheduled alarm is raised in every lane.
    fn gather<L: Lane>(all: [&Self; LANES]) -> Option<Self::Of<L>> {
        let Self { tick, index, next, ref ticks, .. } = *all[0];
        let is_equal = |one: &&Self| one.ticks == *ticks && one.tick == tick;
        all.iter().all(is_equal).then_some(())?;
        Some(ScheduledAlarms {
            detector: D::gather(of_each!(all, |one| &one.detector))?,
            ticks: ticks.clone(),
            tick,
            index,
            next,
        })
    }
}
