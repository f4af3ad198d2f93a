use super::{AugmentedTick, BuiltIn, ForceLaw, ForceMap};
use crate::lane::Lane;

crate::settings! {
    /// Settings of [`Decay`].
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct DecaySettings in "augmentation.decay_" {
        /// Final force of the decay, as a fraction of the force at the alarm.
        ratio: f64 [SHARE] = 0.0,
        /// Time constant of the decay.
        time_constant_s: f64 [POSITIVE] = 0.03,
    }
}

/// `F = F∞ + (F⁻ - F∞) exp(-T/τ)`, `F∞ = ratio · F*`, `|ΔF| <= |F⁻ - F∞| (1 - exp(-T/τ))`: independent of the tissue.
#[derive(Debug, Clone)]
pub struct Decay<L> {
    ratio: L,
    keep: L,
}

impl<L: Lane> BuiltIn for Decay<L> {
    type Settings = DecaySettings;
    type Map = ForceMap;

    fn build(settings: &DecaySettings, tick_s: f64) -> Self {
        Self { ratio: L::splat(settings.ratio), keep: L::splat(libm::exp(-tick_s / settings.time_constant_s)) }
    }

    fn map(&DecaySettings { ratio, time_constant_s }: &DecaySettings) -> Option<ForceMap> {
        Some(ForceMap::Decays { ratio, time_constant_s })
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_force_decays_to_its_ratio_of_the_anchor_and_may_change_by_one_tick_of_decay() {
        let mut law = Decay::<f64>::build(&DecaySettings { ratio: 0.25, time_constant_s: 0.02 }, 1e-3);
        // The last force differs from the anchor, so both enter the result.
        let now = AugmentedTick {
            anchor_n: 4.0,
            last_n: 3.0,
            measured_n: 9.0,
            moved_n: 7.0,
            velocity_m_per_s: 1.0,
            begins: false,
        };
        let (keep, (force_n, allowed_n)) = ((-0.05_f64).exp(), law.augmented(&now));
        assert!((force_n - (1.0 + 2.0 * keep)).abs() < 1e-12, "{force_n}");
        assert!((allowed_n - 2.0 * (1.0 - keep)).abs() < 1e-12, "{allowed_n}");
        let below = law.augmented(&AugmentedTick { last_n: -1.0, ..now });
        assert!((below.0 - (1.0 - 2.0 * keep)).abs() < 1e-12, "from below: {below:?}");
        assert!((below.1 - allowed_n).abs() < 1e-12, "a magnitude: {below:?}");
    }
}
