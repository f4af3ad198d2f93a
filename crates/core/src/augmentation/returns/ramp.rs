use super::{BuiltIn, Return, ReturnMap, ReturnTick, closed_by};
use crate::lane::Lane;

crate::settings! {
    /// Settings of [`Ramp`].
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct RampSettings in "augmentation." {
        /// Speed at which a ramp closes the gap, in addition to the hand's motion.
        catch_up_speed_m_per_s: f64 [POSITIVE] = 0.03,
    }
}

/// `gap = gap⁻ - clamp(gap⁻, -v T, v T)` (section 5.1). The event ends at a gap of 0.
#[derive(Debug, Clone)]
pub struct Ramp<L> {
    step: L,
}

impl<L: Lane> BuiltIn for Ramp<L> {
    type Settings = RampSettings;
    type Map = ReturnMap;

    fn build(settings: &RampSettings, tick_s: f64) -> Self {
        Self { step: L::splat(settings.catch_up_speed_m_per_s * tick_s) }
    }

    fn map(_settings: &RampSettings) -> Option<ReturnMap> {
        Some(ReturnMap::Closes)
    }
}

impl<L: Lane> Return<L> for Ramp<L> {
    #[inline(always)]
    fn gap_m(&mut self, now: &ReturnTick<L>) -> L {
        let closed = closed_by(now.gap_m, self.step);
        L::select(now.begins, now.gap_m, closed)
    }

    #[inline(always)]
    fn may_end(&self, gap_m: L) -> L::Mask {
        gap_m.abs().le(L::zero())
    }
}

crate::lane::gather!(Ramp { step } stored);
