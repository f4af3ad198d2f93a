//! Compares the needle with the *intended motion*: the operator's voluntary trajectory `x_v`, scaled by `s` to the
//! slave, without tremor. With the *gap* `x_e - s x_v`, the excess of the needle after a rupture at `t_r` is
//!
//! ```text
//! excess(t) = (x_e(t) - x_e(t_r)) - s (x_v(t) - x_v(t_r))
//! ```
//! The horizon of a rupture ends at the next one or after [`HORIZON_S`](super::HORIZON_S).

use trocar_core::lane::{Lane, Mask};
use trocar_core::time::nearest_ticks;
use trocar_engine::operator::OperatorTraits;

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Aftermath {
    pub(crate) advance_m: f64,
    pub(crate) deepest_m: f64,
    /// Largest advance beyond the intended motion, and largest depth beyond the largest intended depth, in m.
    pub beyond_intent_m: Option<(f64, f64)>,
}

#[derive(Debug, Clone, Copy)]
struct Horizon {
    rupture: usize,
    end_tick: u64,
    slave_m: f64,
    intended_m: f64,
}

#[derive(Debug, Clone)]
pub struct Pursuit<L: Lane> {
    /// 0 in lanes without a known intention.
    scale: L,
    operators: Vec<OperatorTraits>,
    is_any_known: bool,
    slave_m: L,
    intended_m: L,
    max_gap_m: L,
    max_slave_m: L,
    max_intended_m: L,
    /// Deepest intended position of the run, and the gap at the last tick there.
    deepest_intended_m: L,
    final_gap_m: L,
    /// Last tick of the horizon after the last rupture or accepted alarm, and ticks outside horizons without
    /// withdrawal.
    disturbed_until: L,
    undisturbed_ticks: L,
    withdraws: L::Mask,
    horizons: Vec<Option<Horizon>>,
    horizon_ticks: u64,
    next_end_tick: u64,
}

impl<L: Lane> Pursuit<L> {
    pub fn new(tick_s: f64, horizon_s: f64) -> Self {
        let (zero, lowest) = (L::zero(), L::splat(f64::NEG_INFINITY));
        Self {
            scale: zero,
            operators: vec![OperatorTraits::UNKNOWN; L::WIDTH],
            is_any_known: false,
            slave_m: zero,
            intended_m: zero,
            max_gap_m: zero,
            max_slave_m: zero,
            max_intended_m: zero,
            deepest_intended_m: lowest,
            final_gap_m: zero,
            disturbed_until: L::splat(-1.0),
            undisturbed_ticks: zero,
            withdraws: L::Mask::splat(false),
            horizons: vec![None; L::WIDTH],
            horizon_ticks: nearest_ticks(horizon_s, tick_s),
            next_end_tick: u64::MAX,
        }
    }

    pub fn set_operators(&mut self, traits: impl Fn(usize) -> OperatorTraits) {
        self.operators = (0..L::WIDTH).map(traits).collect();
        self.scale = L::from_lanes(|lane| self.operators[lane].intended_scale.unwrap_or(0.0));
        self.is_any_known = self.operators.iter().any(|operator| operator.intended_scale.is_some());
    }

    pub(crate) fn operator(&self, lane: usize) -> OperatorTraits {
        self.operators[lane]
    }

    pub(crate) fn horizon_ticks(&self) -> u64 {
        self.horizon_ticks
    }

    #[inline(always)]
    pub fn follow(&mut self, tick: u64, intended_position_m: L, slave_position_m: L) -> bool {
        self.slave_m = slave_position_m;
        self.max_slave_m = slave_position_m.max(self.max_slave_m);
        if self.is_any_known {
            let intended = self.scale * intended_position_m;
            let gap = slave_position_m - intended;
            let (zero, one) = (L::zero(), L::splat(1.0));
            let is_first = tick == 0;
            self.withdraws = intended.lt(self.intended_m) & !L::Mask::splat(is_first);
            let is_undisturbed = !self.withdraws & L::splat(tick as f64).gt(self.disturbed_until);
            self.undisturbed_ticks = self.undisturbed_ticks + L::select(is_undisturbed, one, zero);
            self.intended_m = intended;
            self.max_gap_m = gap.max(self.max_gap_m);
            self.max_intended_m = intended.max(self.max_intended_m);
            let is_deepest = intended.ge(self.deepest_intended_m);
            self.deepest_intended_m = intended.max(self.deepest_intended_m);
            self.final_gap_m = L::select(is_deepest, gap, self.final_gap_m);
        }
        tick >= self.next_end_tick
    }

    pub(crate) fn gap_m(&self, lane: usize) -> Option<f64> {
        self.operators[lane].intended_scale.map(|_| (self.slave_m - self.intended_m).lane(lane))
    }

    pub(crate) fn final_gap_m(&self, lane: usize) -> Option<f64> {
        let has_begun = self.deepest_intended_m.lane(lane).is_finite();
        self.operators[lane].intended_scale.filter(|_| has_begun).map(|_| self.final_gap_m.lane(lane))
    }

    pub(crate) fn disturb(&mut self, lanes: L::Mask, tick: u64) {
        let until = L::splat((tick + self.horizon_ticks) as f64);
        self.disturbed_until = L::select(lanes, until, self.disturbed_until);
    }

    pub(crate) fn undisturbed_ticks(&self, lane: usize) -> Option<u64> {
        self.operators[lane].intended_scale.map(|_| self.undisturbed_ticks.lane(lane) as u64)
    }

    pub(crate) fn withdraws(&self, lane: usize) -> bool {
        self.withdraws.lane(lane)
    }

    /// Closes a lane's horizon if it is due or another rupture begins; returns the rupture's index and the motion after
    /// it.
    pub fn close(&mut self, lane: usize, tick: u64, ruptures_again: bool) -> Option<(usize, Aftermath)> {
        let horizon = self.horizons[lane].filter(|horizon| ruptures_again || tick >= horizon.end_tick)?;
        self.horizons[lane] = None;
        self.update_next_end();
        let known = self.operators[lane].intended_scale;
        let deepest_m = self.max_slave_m.lane(lane) - horizon.slave_m;
        let beyond = |_| {
            let excess_m = self.max_gap_m.lane(lane) - (horizon.slave_m - horizon.intended_m);
            let intended_m = self.max_intended_m.lane(lane) - horizon.intended_m;
            (excess_m.max(0.0), (deepest_m - intended_m).max(0.0))
        };
        let advance_m = self.slave_m.lane(lane) - horizon.slave_m;
        Some((horizon.rupture, Aftermath { advance_m, deepest_m, beyond_intent_m: known.map(beyond) }))
    }

    pub fn open(&mut self, lane: usize, tick: u64, rupture: usize) {
        let (slave_m, intended_m) = (self.slave_m.lane(lane), self.intended_m.lane(lane));
        self.max_gap_m = self.max_gap_m.with_lane(lane, slave_m - intended_m);
        self.max_slave_m = self.max_slave_m.with_lane(lane, slave_m);
        self.max_intended_m = self.max_intended_m.with_lane(lane, intended_m);
        self.horizons[lane] = Some(Horizon { rupture, end_tick: tick + self.horizon_ticks, slave_m, intended_m });
        self.update_next_end();
    }

    pub(crate) fn abandon(&mut self, lane: usize) {
        self.horizons[lane] = None;
        self.update_next_end();
    }

    fn update_next_end(&mut self) {
        let ends = self.horizons.iter().flatten().map(|horizon| horizon.end_tick);
        self.next_end_tick = ends.min().unwrap_or(u64::MAX);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_horizon_is_due_at_its_end_unless_it_is_abandoned() {
        let mut pursuit = Pursuit::<f64>::new(1e-3, 0.01);
        assert!(!pursuit.follow(0, 0.0, 0.5));
        pursuit.open(0, 0, 3);
        assert!((1..10).all(|tick| !pursuit.follow(tick, 0.0, 0.5)));
        assert!(pursuit.close(0, 9, false).is_none());
        assert!(pursuit.follow(10, 0.0, 0.75));
        let (rupture, aftermath) = pursuit.close(0, 10, false).expect("it is due");
        assert_eq!((rupture, aftermath.advance_m, aftermath.beyond_intent_m), (3, 0.25, None));
        pursuit.open(0, 10, 4);
        pursuit.abandon(0);
        assert!(!pursuit.follow(99, 0.0, 0.5) && pursuit.close(0, 99, true).is_none());
    }
}
