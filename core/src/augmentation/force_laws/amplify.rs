//! A force whose variation is scaled.

use super::{AugmentedTick, ForceLaw};
use crate::lane::Lane;

/// `F = max(F* + κ (F_e - F*), min(F*, 0))`: the measured variation is scaled, and its size still tells.
///
/// `|ΔF| <= κ |ΔF_e|`. The floor of a force that pulled already is that force, as a jump to 0 would be felt.
#[derive(Debug, Clone)]
pub struct Amplify<L> {
    gain: L,
}

impl<L: Lane> Amplify<L> {
    /// A law of the gain κ, at least 1.
    #[must_use]
    pub fn new(gain: f64) -> Self {
        Self { gain: L::splat(gain) }
    }
}

impl<L: Lane> ForceLaw<L> for Amplify<L> {
    #[inline(always)]
    fn augmented(&mut self, now: &AugmentedTick<L>) -> (L, L) {
        let scaled = now.anchor_n + self.gain * (now.measured_n - now.anchor_n);
        (scaled.max(now.anchor_n.min(L::zero())), self.gain * now.moved_n)
    }
}

crate::lane::gather!(Amplify { gain });
