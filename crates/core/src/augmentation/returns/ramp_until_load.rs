use super::{BuiltIn, Return, ReturnMap, ReturnTick, closed_by};
use crate::lane::Lane;

crate::settings! {
    /// Settings of [`RampUntilLoad`].
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct RampUntilLoadSettings in "augmentation." {
        /// Speed at which a ramp until load closes the gap, in addition to the hand's motion.
        approach_speed_m_per_s: f64 [POSITIVE] = 0.03,
        /// Rise of the measured force, above its minimum while re-engaging, at which the ramp until load stops.
        stop_rise_n: f64 [POSITIVE] = 0.3,
    }
}

/// A ramp up to `stop_rise_n` above the minimum force since the release.
#[derive(Debug, Clone)]
pub struct RampUntilLoad<L> {
    step: L,
    stop_rise: L,
    force: L,
    /// Negative infinity after a stop.
    min_force: L,
}

impl<L: Lane> BuiltIn for RampUntilLoad<L> {
    type Settings = RampUntilLoadSettings;
    type Map = ReturnMap;

    fn build(settings: &RampUntilLoadSettings, tick_s: f64) -> Self {
        Self {
            step: L::splat(settings.approach_speed_m_per_s * tick_s),
            stop_rise: L::splat(settings.stop_rise_n),
            force: L::zero(),
            min_force: L::zero(),
        }
    }
}

impl<L: Lane> RampUntilLoad<L> {
    #[inline(always)]
    fn is_loaded(&self) -> L::Mask {
        (self.force - self.min_force).ge(self.stop_rise)
    }
}

impl<L: Lane> Return<L> for RampUntilLoad<L> {
    #[inline(always)]
    fn gap_m(&mut self, now: &ReturnTick<L>) -> L {
        self.force = now.force_n;
        self.min_force = L::select(now.begins, now.force_n, now.force_n.min(self.min_force));
        let is_loaded = self.is_loaded();
        self.min_force = L::select(is_loaded, L::splat(f64::NEG_INFINITY), self.min_force);
        let closed = closed_by(now.gap_m, self.step);
        L::select(now.begins | is_loaded, now.gap_m, closed)
    }

    #[inline(always)]
    fn may_end(&self, gap_m: L) -> L::Mask {
        gap_m.abs().le(L::zero()) | self.is_loaded()
    }
}

crate::lane::gather!(RampUntilLoad { step, stop_rise, force, min_force } stored);
