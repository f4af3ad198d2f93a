use super::{AugmentedTick, BuiltIn, ForceLaw, ForceMap};
use crate::lane::Lane;

crate::settings! {
    /// Settings of [`Amplify`].
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct AmplifySettings in "augmentation." {
        /// Gain (κ) of the amplify law.
        gain: f64 at "augmentation.amplification" [AT_LEAST_ONE] = 2.0,
    }
}

/// `F = max(F* + κ (F_e - F*), min(F*, 0))`, `|ΔF| <= κ |ΔF_e|`
///
/// A force that already pulls is the floor: a jump to 0 would be felt.
#[derive(Debug, Clone)]
pub struct Amplify<L> {
    gain: L,
}

impl<L: Lane> BuiltIn for Amplify<L> {
    type Settings = AmplifySettings;
    type Map = ForceMap;

    fn build(settings: &AmplifySettings, _tick_s: f64) -> Self {
        Self { gain: L::splat(settings.gain) }
    }

    fn map(settings: &AmplifySettings) -> Option<ForceMap> {
        Some(ForceMap::FollowsTissue { gain: settings.gain })
    }
}

impl<L: Lane> ForceLaw<L> for Amplify<L> {
    #[inline(always)]
    fn augmented(&mut self, now: &AugmentedTick<L>) -> (L, L) {
        let scaled = now.anchor_n + self.gain * (now.measured_n - now.anchor_n);
        (scaled.max(now.anchor_n.min(L::zero())), self.gain * now.moved_n)
    }
}

crate::lane::gather!(Amplify { gain } stored);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_variation_is_scaled_down_to_0_or_to_a_force_that_already_pulls() {
        let mut law = Amplify::<f64>::build(&AmplifySettings { gain: 3.0 }, 1e-3);
        let mut at = |anchor_n, measured_n| {
            law.augmented(&AugmentedTick {
                anchor_n,
                last_n: 100.0,
                measured_n,
                moved_n: 0.5,
                velocity_m_per_s: 1.0,
                begins: false,
            })
        };
        assert_eq!(at(4.0, 3.5), (2.5, 1.5));
        assert_eq!(at(4.0, 5.0), (7.0, 1.5), "a rise too");
        assert_eq!(at(4.0, 2.0), (0.0, 1.5), "floored at 0");
        assert_eq!(at(-1.0, -2.0), (-1.0, 1.5), "floored at the force that pulls");
        assert_eq!(at(-1.0, 1.0), (5.0, 1.5));
    }
}
