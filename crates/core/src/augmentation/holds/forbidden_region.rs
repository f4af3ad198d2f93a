use super::{BuiltIn, HeldTick, Hold, HoldMap};
use crate::lane::Lane;

crate::settings! {
    /// Settings of [`ForbiddenRegion`].
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct ForbiddenRegionSettings in "augmentation." {
        /// Distance from the position at the alarm to the forbidden region.
        margin_m: f64 at "augmentation.region_margin_m" [NON_NEGATIVE] = 0.0,
    }
}

/// `x_ref = min(hand, anchor + margin)`: stops the insertion, but allows withdrawal.
#[derive(Debug, Clone)]
pub struct ForbiddenRegion<L> {
    margin: L,
}

impl<L: Lane> BuiltIn for ForbiddenRegion<L> {
    type Settings = ForbiddenRegionSettings;
    type Map = HoldMap;

    fn build(settings: &ForbiddenRegionSettings, _tick_s: f64) -> Self {
        Self { margin: L::splat(settings.margin_m) }
    }
}

impl<L: Lane> Hold<L> for ForbiddenRegion<L> {
    #[inline(always)]
    fn reference_m(&self, now: &HeldTick<L>) -> L {
        now.hand_m.min(now.anchor_m + self.margin)
    }
}

crate::lane::gather!(ForbiddenRegion { margin } stored);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_reference_follows_the_hand_up_to_the_margin_behind_the_anchor() {
        let region = ForbiddenRegion::<f64>::build(&ForbiddenRegionSettings { margin_m: 0.25 }, 1e-3);
        let to = |hand_m| region.reference_m(&HeldTick { anchor_m: 1.0, last_m: 9.0, hand_m });
        assert_eq!([to(0.5), to(1.2), to(1.25), to(2.0)], [0.5, 1.2, 1.25, 1.25]);
    }
}
