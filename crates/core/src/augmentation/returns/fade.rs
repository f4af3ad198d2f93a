use super::{BuiltIn, Return, ReturnMap, ReturnTick};
use crate::lane::Lane;

crate::settings! {
    /// Settings of [`Fade`].
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct FadeSettings in "augmentation." {
        /// Time constant with which a fading gap closes.
        gap_time_constant_s: f64 [POSITIVE] = 4.0,
    }
}

/// A smaller gap is closed, because subnormal numbers are slow.
const SMALLEST_M: f64 = 1e-12;

/// `gap = gap⁻ exp(-T/τ)`, also in teleoperation. With a long `τ` the next layer's load first pushes the hand back.
#[derive(Debug, Clone)]
pub struct Fade<L> {
    keep: L,
}

impl<L: Lane> BuiltIn for Fade<L> {
    type Settings = FadeSettings;
    type Map = ReturnMap;

    fn build(settings: &FadeSettings, tick_s: f64) -> Self {
        Self { keep: L::splat(libm::exp(-tick_s / settings.gap_time_constant_s)) }
    }

    fn map(settings: &FadeSettings) -> Option<ReturnMap> {
        Some(ReturnMap::Fades { time_constant_s: settings.gap_time_constant_s })
    }
}

impl<L: Lane> Return<L> for Fade<L> {
    const CONTINUES: bool = true;

    #[inline(always)]
    fn gap_m(&mut self, now: &ReturnTick<L>) -> L {
        let kept = now.gap_m * self.keep;
        let closed = L::select(kept.abs().lt(L::splat(SMALLEST_M)), L::zero(), kept);
        L::select(now.begins, now.gap_m, closed)
    }
}

crate::lane::gather!(Fade { keep } stored);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_gap_falls_to_a_share_of_1_over_e_in_a_time_constant_and_then_to_0() {
        let mut fade = Fade::<f64>::build(&FadeSettings { gap_time_constant_s: 0.5 }, 1e-3);
        let mut gap_m = -0.01;
        for tick in 0..=500 {
            gap_m = fade.gap_m(&ReturnTick { gap_m, hand_step_m: 1.0, force_n: 0.0, begins: tick == 0 });
            let expected_m = -0.01 * (-f64::from(tick) / 500.0).exp();
            assert!((gap_m - expected_m).abs() < 1e-15, "{tick}: {gap_m} {expected_m}");
        }
        for _ in 0..12_000 {
            gap_m = fade.gap_m(&ReturnTick { gap_m, hand_step_m: 0.0, force_n: 0.0, begins: false });
        }
        assert_eq!(gap_m, 0.0);
    }
}
