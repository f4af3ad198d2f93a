use crate::lane::{Lane, Mask};

/// Relative to the alarm's fall.
const LEAST_SHARE: f64 = 0.2;

const DECAY_S: f64 = 0.15;

/// Rise that is a new load, relative to the alarm's fall.
const LOADED_SHARE: f64 = 0.65;

/// Half a period at 4 Hz.
const LONGEST_SWING_S: f64 = 0.125;

/// Smallest change that is a turn, relative to the fall and to the usual change.
const TURN_SHARE: f64 = 0.02;
const TURN_SCALES: f64 = 3.0;

/// A fall beyond this share of the last rise, within this share of its time, is sudden.
const SUDDEN_SHARE: f64 = 0.5;
const SUDDEN_TIME: f64 = 0.25;

/// The ring-down after an alarm. Its swings decay and take as long down as up, so a fall counts only below the last
/// trough lowered by sinking crests (relaxation), or if it is sudden.
#[derive(Debug, Clone)]
pub(super) struct Aftermath<L> {
    top: L,
    lowest: L,
    trough: L,
    crest: L,
    /// From the last crest but one to the last.
    trend: L,
    /// Bins of the last rise.
    rise: L,
    extreme: L,
    since_extreme: L,
    since_turn: L,
    /// 1: rising, -1: falling, 0: no ring-down.
    direction: L,
    share: L,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct AftermathTimes {
    longest_swing: f64,
    decay: f64,
}

impl AftermathTimes {
    pub(super) fn of(bin_s: f64) -> Self {
        let longest_swing = libm::round(LONGEST_SWING_S / bin_s).max(2.0);
        Self { longest_swing, decay: libm::exp(-bin_s / DECAY_S) }
    }
}

#[derive(Debug, Clone, Copy)]
pub(super) struct FallLimits<L> {
    pub(super) largest: L,
    pub(super) least: L,
}

impl<L: Lane> Aftermath<L> {
    pub(super) fn new() -> Self {
        let zero = L::zero();
        Self {
            top: zero,
            lowest: zero,
            trough: zero,
            crest: zero,
            trend: zero,
            rise: zero,
            extreme: zero,
            since_extreme: zero,
            since_turn: zero,
            direction: zero,
            share: zero,
        }
    }

    #[inline(always)]
    pub(super) fn begin(&mut self, mask: L::Mask, top: L, force: L) {
        // There is no trend until the second crest.
        let first = mask & !self.is_active();
        let zero = L::zero();
        self.crest = L::select(first, L::splat(f64::MIN), self.crest);
        self.top = L::select(mask, top, self.top);
        self.lowest = L::select(mask, force, self.lowest);
        self.trough = L::select(mask, force, self.trough);
        self.trend = L::select(mask, zero, self.trend);
        self.rise = L::select(mask, zero, self.rise);
        self.extreme = L::select(mask, force, self.extreme);
        self.since_extreme = L::select(mask, zero, self.since_extreme);
        self.since_turn = L::select(mask, zero, self.since_turn);
        self.direction = L::select(mask, L::splat(-1.0), self.direction);
        self.share = L::select(mask, L::splat(LEAST_SHARE), self.share);
    }

    #[inline(always)]
    pub(super) fn update(&mut self, force: L, scale: L, falls: L::Mask, times: &AftermathTimes) {
        let (zero, one) = (L::zero(), L::splat(1.0));
        let active = self.is_active();
        if !active.any() {
            return;
        }
        self.lowest = L::select(falls, self.lowest.min(force), self.lowest);
        self.trough = L::select(falls, self.trough.min(force), self.trough);
        self.share = L::select(falls, self.share, self.share * L::splat(times.decay));
        let fall = (self.top - self.lowest).max(zero);

        let rises = self.direction.gt(zero);
        let extreme = L::select(rises, self.extreme.max(force), self.extreme.min(force));
        let is_extreme = !(extreme - force).abs().gt(zero);
        let since_extreme = L::select(is_extreme, zero, self.since_extreme + one);
        let since_turn = self.since_turn + one;
        let margin = (fall * L::splat(TURN_SHARE)).max(scale * L::splat(TURN_SCALES));
        let turns = (extreme - force).abs().gt(margin) & active;
        let (turns_up, turns_down) = (turns & !rises, turns & rises);
        self.trough = L::select(turns_up, extreme, self.trough);
        self.trend = L::select(turns_down, (extreme - self.crest).min(zero), self.trend);
        self.crest = L::select(turns_down, extreme, self.crest);
        self.rise = L::select(turns_down, since_turn - since_extreme, self.rise);
        self.since_turn = L::select(turns, since_extreme, since_turn);
        self.extreme = L::select(turns, force, extreme);
        self.since_extreme = L::select(turns, zero, since_extreme);
        self.direction = L::select(turns, -self.direction, self.direction);

        let is_loaded = force.gt(self.lowest + fall * L::splat(LOADED_SHARE));
        let is_over = is_loaded | self.since_turn.gt(L::splat(times.longest_swing));
        self.direction = L::select(active & is_over & !falls, zero, self.direction);
    }

    #[inline(always)]
    fn is_active(&self) -> L::Mask {
        self.direction.abs().gt(L::zero())
    }

    #[inline(always)]
    pub(super) fn limits(&self, force: L) -> FallLimits<L> {
        let active = self.is_active();
        let unlimited = L::splat(f64::MAX);
        let is_sudden = (self.crest - force).gt((self.crest - self.trough) * L::splat(SUDDEN_SHARE))
            & (self.since_turn + L::splat(1.0)).lt(self.rise * L::splat(SUDDEN_TIME))
            & self.direction.lt(L::zero());
        let largest = L::select(is_sudden, unlimited, self.trough + self.trend - force);
        FallLimits {
            largest: L::select(active, largest, unlimited),
            least: L::select(active, (self.top - self.lowest) * self.share, L::zero()),
        }
    }
}

crate::lane::gather!(Aftermath {
    top, lowest, trough, crest, trend, rise, extreme, since_extreme, since_turn, direction, share
} stored);

#[cfg(test)]
mod tests {
    use super::*;

    /// The state after an alarm on a fall from 5 N to 2 N, and the following forces (N), one per bin of 1 ms.
    fn after(forces: impl IntoIterator<Item = f64>) -> Aftermath<f64> {
        let mut aftermath = Aftermath::<f64>::new();
        aftermath.begin(true, 5.0, 2.0);
        for force in forces {
            aftermath.update(force, 0.001, false, &AftermathTimes::of(1e-3));
        }
        aftermath
    }

    /// A straight line between two forces (N), without the first.
    fn line(from: f64, to: f64, bins: u32) -> impl Iterator<Item = f64> {
        (1..=bins).map(move |bin| from + (to - from) * f64::from(bin) / f64::from(bins))
    }

    #[test]
    fn before_an_alarm_and_in_other_lanes_no_fall_is_limited() {
        let mut aftermath = Aftermath::<f64>::new();
        aftermath.begin(false, 5.0, 2.0);
        let limits = aftermath.limits(1.0);
        assert_eq!((limits.largest, limits.least), (f64::MAX, 0.0));
    }

    #[test]
    fn a_swing_counts_by_what_it_goes_below_the_last_trough() {
        let aftermath = after(line(2.0, 2.8, 20).chain(line(2.8, 1.7, 20)));
        let limits = aftermath.limits(1.7);
        assert!((limits.largest - 0.3).abs() < 1e-12, "{limits:?}");
        // A fifth of the fall of 3 N, decayed for 40 ms.
        assert!((limits.least - 0.6 * (-40.0_f64 / 150.0).exp()).abs() < 1e-12, "{limits:?}");
    }

    #[test]
    fn a_fall_that_is_much_faster_than_the_rise_before_it_counts_in_full() {
        let aftermath = after(line(2.0, 2.8, 40).chain(line(2.8, 2.2, 3)));
        assert_eq!(aftermath.limits(2.2).largest, f64::MAX);
        let slow = after(line(2.0, 2.8, 40).chain(line(2.8, 2.2, 12)));
        assert!(slow.limits(2.2).largest < 0.0, "a swing");
    }

    #[test]
    fn sinking_crests_predict_a_lower_trough() {
        let swings = line(2.0, 2.8, 20).chain(line(2.8, 1.8, 20)).chain(line(1.8, 2.5, 20)).chain(line(2.5, 1.4, 20));
        // The second crest is 0.3 N below the first one, and the trough between them is 1.8 N.
        assert!((after(swings).limits(1.4).largest - 0.1).abs() < 1e-12);
    }

    #[test]
    fn a_ring_down_ends_with_a_new_load_or_without_a_turn() {
        let is_over = |aftermath: Aftermath<f64>| aftermath.limits(0.0).largest == f64::MAX;
        // 0.65 of the fall of 3 N.
        assert!(!is_over(after(line(2.0, 3.9, 50))) && is_over(after(line(2.0, 4.0, 50))));
        assert!(!is_over(after(line(2.0, 2.5, 120))) && is_over(after(line(2.0, 2.5, 130))));
    }
}
