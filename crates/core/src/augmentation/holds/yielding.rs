use super::{BuiltIn, HeldTick, Hold, HoldMap};
use crate::lane::Lane;

crate::settings! {
    /// Settings of [`Yielding`].
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct YieldingSettings in "augmentation." {
        /// Distance beyond the position at the alarm that the hand must push before the needle moves on.
        distance_m: f64 at "augmentation.yield_distance_m" [NON_NEGATIVE] = 0.005,
    }
}

/// `x_ref = min(hand, max(anchor, hand - d))`, a virtual fixture (Rosenberg, IEEE VRAIS 1993).
#[derive(Debug, Clone)]
pub struct Yielding<L> {
    distance: L,
}

impl<L: Lane> BuiltIn for Yielding<L> {
    type Settings = YieldingSettings;
    type Map = HoldMap;

    fn build(settings: &YieldingSettings, _tick_s: f64) -> Self {
        Self { distance: L::splat(settings.distance_m) }
    }
}

impl<L: Lane> Hold<L> for Yielding<L> {
    #[inline(always)]
    fn reference_m(&self, now: &HeldTick<L>) -> L {
        now.hand_m.min(now.anchor_m.max(now.hand_m - self.distance))
    }
}

crate::lane::gather!(Yielding { distance } stored);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_needle_rests_until_the_hand_has_pushed_by_the_distance_and_follows_a_withdrawal() {
        let hold = Yielding::<f64>::build(&YieldingSettings { distance_m: 0.5 }, 1e-3);
        let to = |hand_m| hold.reference_m(&HeldTick { anchor_m: 1.0, last_m: 9.0, hand_m });
        assert_eq!([to(0.75), to(1.0), to(1.25), to(1.5), to(2.0)], [0.75, 1.0, 1.0, 1.0, 1.5]);
    }
}
