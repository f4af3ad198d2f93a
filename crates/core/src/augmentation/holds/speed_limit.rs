use super::{BuiltIn, HeldTick, Hold, HoldMap};
use crate::lane::Lane;

crate::settings! {
    /// Settings of [`SpeedLimit`].
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct SpeedLimitSettings in "augmentation." {
        /// Largest speed of the slave during an event with a speed limit.
        speed_m_per_s: f64 at "augmentation.hold_speed_m_per_s" [POSITIVE] = 0.005,
    }
}

/// `x_ref = x_ref⁻ + clamp(hand - x_ref⁻, -v T, v T)`
#[derive(Debug, Clone)]
pub struct SpeedLimit<L> {
    step: L,
}

impl<L: Lane> BuiltIn for SpeedLimit<L> {
    type Settings = SpeedLimitSettings;
    type Map = HoldMap;

    fn build(settings: &SpeedLimitSettings, tick_s: f64) -> Self {
        Self { step: L::splat(settings.speed_m_per_s * tick_s) }
    }
}

impl<L: Lane> Hold<L> for SpeedLimit<L> {
    #[inline(always)]
    fn reference_m(&self, now: &HeldTick<L>) -> L {
        now.last_m + (now.hand_m - now.last_m).clamp(-self.step, self.step)
    }
}

crate::lane::gather!(SpeedLimit { step } stored);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_reference_moves_by_at_most_the_speed_in_either_direction() {
        let limit = SpeedLimit::<f64>::build(&SpeedLimitSettings { speed_m_per_s: 0.5 }, 1e-2);
        let to = |hand_m| limit.reference_m(&HeldTick { anchor_m: 9.0, last_m: 1.0, hand_m });
        assert_eq!([to(2.0), to(0.0), to(1.0)], [1.005, 0.995, 1.0]);
        assert!((to(1.002) - 1.002).abs() < 1e-15);
    }
}
