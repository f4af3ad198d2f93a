//! A force that decays after the alarm, whatever the tissue does.

use super::{AugmentedTick, ForceLaw};
use crate::lane::Lane;

/// `F = F∞ + (F⁻ - F∞) exp(-T/τ)` with `F∞ = ratio · F*`: the same crisp drop at every rupture, whatever its size.
///
/// `|ΔF| <= |F⁻ - F∞| (1 - exp(-T/τ))`.
#[derive(Debug, Clone)]
pub struct Decay<L> {
    ratio: L,
    keep: L,
}

impl<L: Lane> Decay<L> {
    /// A decay to a share of `F*`, from 0 to 1, with a time constant in s, above 0, on ticks `tick_s` apart (s).
    #[must_use]
    pub fn new(ratio: f64, time_constant_s: f64, tick_s: f64) -> Self {
        Self { ratio: L::splat(ratio), keep: L::splat(libm::exp(-tick_s / time_constant_s)) }
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

crate::lane::gather!(Decay { ratio, keep });
