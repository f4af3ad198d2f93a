//! A force that decays after the alarm, independent of the tissue.

use super::{AugmentedTick, BuiltIn, ForceLaw};
use crate::lane::Lane;

crate::settings! {
    /// Settings of the decay.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct DecaySettings in "augmentation.decay_" {
        /// Final force of the decay, as a fraction of the force at the alarm.
        ratio: f64 [SHARE] = 0.0,
        /// Time constant of the decay.
        time_constant_s: f64 [POSITIVE] = 0.03,
    }
}

/// `F = F∞ + (F⁻ - F∞) exp(-T/τ)` with `F∞ = ratio · F*`: the same sharp drop at every rupture, independent of its
/// size.
///
/// `|ΔF| <= |F⁻ - F∞| (1 - exp(-T/τ))`.
#[derive(Debug, Clone)]
pub struct Decay<L> {
    ratio: L,
    keep: L,
}

impl<L: Lane> BuiltIn for Decay<L> {
    type Settings = DecaySettings;

    fn build(settings: &DecaySettings, tick_s: f64) -> Self {
        Self { ratio: L::splat(settings.ratio), keep: L::splat(libm::exp(-tick_s / settings.time_constant_s)) }
    }
}

impl<L: Lane> ForceLaw<L> for Decay<L> {
    #[inline(always)]
    fn augmented(&mut self, now: &AugmentedTick<L>) -> (L, L) {
        let end = self.ratio * now.anchor_n;
        let gap = now.last_n - end;
        (end + gap * self.keep, gap.abs() * (L::splat(1.0) - self.keep))
    }
}

crate::lane::gather!(Decay { ratio, keep } stored);
