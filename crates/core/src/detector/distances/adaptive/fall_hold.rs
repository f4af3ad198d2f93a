use super::tare::Tare;
use super::times::Times;
use super::{LEAST_SHARE, NEW_LOAD, NEW_LOAD_BINS};
use crate::lane::{Lane, Mask};

/// The rest of the fall after an alarm.
#[derive(Debug, Clone)]
pub(super) struct FallHold<L> {
    pub(super) lowest: L,
    /// Negative if no fall is held.
    pub(super) since_lowest: L,
    pub(super) bins: L,
}

pub(super) struct FallState<L: Lane> {
    pub(super) was_holding: L::Mask,
    pub(super) ended: Option<L::Mask>,
}

impl<L: Lane> FallHold<L> {
    #[inline(always)]
    pub(super) fn begin(&mut self, mask: L::Mask, force: L) {
        self.lowest = L::select(mask, force, self.lowest);
        self.since_lowest = L::select(mask, L::zero(), self.since_lowest);
        self.bins = L::select(mask, L::zero(), self.bins);
    }

    /// Ends after two references without a further fall, with a new load, or after `times.hold`.
    #[inline(always)]
    pub(super) fn update(&mut self, force: L, scale: L, tare: &Tare<L>, times: &Times) -> FallState<L> {
        let one = L::splat(1.0);
        let was_holding = self.since_lowest.ge(L::zero());
        if !was_holding.any() {
            return FallState { was_holding, ended: None };
        }
        let is_lower =
            force.lt(self.lowest - scale.max(L::splat(LEAST_SHARE) * tare.size(self.lowest, self.lowest, scale)));
        self.lowest = L::select(is_lower, force, self.lowest);
        let since = L::select(is_lower, L::zero(), self.since_lowest + one);
        self.bins = self.bins + one;
        let is_loaded = force.gt(self.lowest + L::splat(NEW_LOAD) * scale)
            & since.ge(L::splat(NEW_LOAD_BINS))
            & self.bins.ge(L::splat(times.merge));
        let is_over = since.ge(L::splat(2.0 * times.reference as f64)) | self.bins.ge(L::splat(times.hold));
        let ends = was_holding & (is_loaded | is_over);
        self.since_lowest = L::select(was_holding & !ends, since, -one);
        FallState { was_holding, ended: ends.any().then_some(ends) }
    }
}

crate::lane::gather!(FallHold { lowest, since_lowest, bins } stored);

#[cfg(test)]
mod tests {
    use super::*;

    fn hold() -> (FallHold<f64>, Times) {
        (FallHold { lowest: 0.0, since_lowest: -1.0, bins: 0.0 }, Times::of(1e-3))
    }

    /// The number of bins after which a fall that begins at 4 N ends, for the forces of the following bins.
    fn ends_after(scale: f64, force: impl Fn(u32) -> f64) -> u32 {
        let (mut hold, times) = hold();
        assert!(!hold.update(4.0, scale, &Tare::new(), &times).was_holding, "not before an alarm");
        hold.begin(false, 4.0);
        assert!(!hold.update(4.0, scale, &Tare::new(), &times).was_holding, "in another lane");
        hold.begin(true, 4.0);
        for bin in 1..500 {
            let held = hold.update(force(bin), scale, &Tare::new(), &times);
            assert!(held.was_holding, "{bin}");
            if held.ended == Some(true) {
                assert!(!hold.update(force(bin), scale, &Tare::new(), &times).was_holding, "it has ended");
                return bin;
            }
            assert_eq!(held.ended, None);
        }
        panic!("it does not end");
    }

    #[test]
    fn a_held_fall_ends_after_two_references_without_a_further_fall() {
        assert_eq!(ends_after(0.01, |_| 4.0), 30);
        // At bin 20 the force loses a quarter more, which restarts the 30 bins.
        assert_eq!(ends_after(0.01, |bin| if bin < 20 { 4.0 } else { 3.0 }), 50);
        // A loss of less than a tenth of the force, or less than the scale, is not a further fall.
        assert_eq!(ends_after(0.01, |bin| if bin < 20 { 4.0 } else { 3.7 }), 30);
        assert_eq!(ends_after(2.0, |bin| if bin < 20 { 4.0 } else { 3.0 }), 30);
    }

    #[test]
    fn a_held_fall_ends_at_the_latest_after_150_ms() {
        assert_eq!(ends_after(1e-30, |bin| 4.0 * 0.85_f64.powi(bin as i32)), 150);
    }

    #[test]
    fn a_new_load_ends_a_held_fall_after_30_ms_once_it_has_lasted_two_bins() {
        // The force falls until bin 35. Then it is ten scales above its lowest value.
        let falls = |after: f64| move |bin: u32| if bin <= 35 { 4.0 * 0.85_f64.powi(bin as i32) } else { after };
        assert_eq!(ends_after(0.001, falls(0.1)), 37);
        assert_eq!(ends_after(0.001, falls(0.015)), 65, "a smaller rise is no load");
        assert_eq!(ends_after(0.01, |_| 4.11), 30, "not within 30 ms");
    }
}
