use std::sync::Arc;

use super::{Reaction, Tissue};
use trocar_core::lane::{Lane, Mask};

/// Independent of the slave's motion, as in the paper (5.2); the last force is held.
#[derive(Debug, Clone)]
pub struct RecordedForce {
    force_n: Arc<[f64]>,
    last_force_n: f64,
    rupture_ticks: Arc<[u64]>,
    ruptures: usize,
    next_rupture: u64,
}

impl RecordedForce {
    pub fn new(force_n: Arc<[f64]>, rupture_ticks: Arc<[u64]>) -> Self {
        let last_force_n = force_n.last().copied().unwrap_or(0.0);
        let next_rupture = rupture_ticks.first().copied().unwrap_or(u64::MAX);
        Self { force_n, last_force_n, rupture_ticks, ruptures: 0, next_rupture }
    }

    /// Keeps other ticks fast.
    #[cold]
    #[inline]
    fn held(&self) -> f64 {
        self.last_force_n
    }
}

impl<L: Lane> Tissue<L> for RecordedForce {
    #[inline(always)]
    fn react(&mut self, tick: u64, _position_m: L, _velocity_m_per_s: L) -> Reaction<L> {
        let force = self.force_n.get(tick as usize).copied().unwrap_or_else(|| self.held());
        let ruptured = tick == self.next_rupture;
        if ruptured {
            self.ruptures += 1;
            self.next_rupture = self.rupture_ticks.get(self.ruptures).copied().unwrap_or(u64::MAX);
        }
        Reaction { force_n: L::splat(force), ruptured: L::Mask::splat(ruptured) }
    }
}

impl trocar_core::lane::Gather for RecordedForce {
    type Of<L: Lane> = Self;

    fn gather<L: Lane>(all: [&Self; trocar_core::lane::LANES]) -> Option<Self> {
        use trocar_core::lane::same_list;
        let equal = same_list(trocar_core::lane::of_each!(all, |one| &one.force_n))
            && same_list(trocar_core::lane::of_each!(all, |one| &one.rupture_ticks));
        let at_once = all.iter().all(|one| one.ruptures == all[0].ruptures);
        (equal && at_once).then(|| all[0].clone())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_force_is_replayed_by_tick_and_held_after_the_end() {
        let mut tissue = RecordedForce::new(Arc::from([1.0, 2.0, 3.0]), Arc::from([1]));
        let reactions: Vec<(f64, bool)> =
            (0..5).map(|k| Tissue::<f64>::react(&mut tissue, k, 0.0, 0.0)).map(|r| (r.force_n, r.ruptured)).collect();
        assert_eq!(reactions, [(1.0, false), (2.0, true), (3.0, false), (3.0, false), (3.0, false)]);
    }

    #[test]
    fn every_labelled_rupture_is_reported_once() {
        let mut tissue = RecordedForce::new(Arc::from([0.0; 10]), Arc::from([0, 3, 4, 12]));
        let ruptures: Vec<u64> = (0..20).filter(|&k| Tissue::<f64>::react(&mut tissue, k, 0.0, 0.0).ruptured).collect();
        assert_eq!(ruptures, [0, 3, 4, 12]);
        let mut empty = RecordedForce::new(Arc::from([]), Arc::from([]));
        let reaction = Tissue::<f64>::react(&mut empty, 0, 0.0, 0.0);
        assert_eq!((reaction.force_n, reaction.ruptured), (0.0, false));
    }
}
