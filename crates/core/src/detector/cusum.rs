use super::DistanceSettings;
use crate::lane::Lane;

crate::settings! {
    /// Threshold, drift and cap.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct CusumSettings in "detector." given (distance: &DistanceSettings) {
        /// Threshold (γ): an alarm is raised when g exceeds it, in the distance's unit.
        threshold: f64 [POSITIVE] => "what one sample of a rupture adds; 1.98e-2 N² for the paper's variances"
            distance.tuning().0,
        /// Drift (ν), subtracted at each sample (eq. 27), in the distance's unit.
        drift: f64 [ANY] => "halfway between the hypotheses; 2.02e-2 N² for the paper's variances" distance.tuning().1,
        /// Largest value of g, in the distance's unit.
        ///
        /// Without a cap one sample of a 15 N drop sets `g = 225 N²`, which takes 11,000 samples to fall.
        cap: f64 [POSITIVE] => "ten thresholds" 10.0 * threshold,
    }
    where cap: |s| s.cap > s.threshold, "above detector.threshold";
}

/// `g_0 = 0`, `g_k = min(max(g_{k-1} + s_k - ν, 0), cap)` (eq. 27).
#[derive(Debug, Clone)]
pub(super) struct Cusum<L> {
    threshold: L,
    drift: L,
    cap: L,
    value: L,
}

impl<L: Lane> Cusum<L> {
    pub(super) fn new(settings: &CusumSettings) -> Self {
        Self {
            threshold: L::splat(settings.threshold),
            drift: L::splat(settings.drift),
            cap: L::splat(settings.cap),
            value: L::zero(),
        }
    }

    /// Returns `g_k` and the lanes above the threshold.
    #[inline(always)]
    pub(super) fn update(&mut self, distance: L) -> (L, L::Mask) {
        self.value = (self.value + (distance - self.drift)).clamp(L::zero(), self.cap);
        (self.value, self.value.gt(self.threshold))
    }

    /// Without accumulation: `g_k = min(max(s_k - ν, 0), cap)`.
    #[inline(always)]
    pub(super) fn hold(&mut self, distance: L) -> (L, L::Mask) {
        self.value = (distance - self.drift).clamp(L::zero(), self.cap);
        (self.value, self.value.gt(self.threshold))
    }

    pub(super) fn set_thresholds(&mut self, threshold: L, cap: L) {
        (self.threshold, self.cap) = (threshold, cap);
    }

    #[inline(always)]
    pub(super) fn reset(&mut self, mask: L::Mask) {
        self.value = L::select(mask, L::zero(), self.value);
    }
}

crate::lane::gather!(Cusum { threshold, drift, cap, value } stored);

#[cfg(test)]
mod tests {
    use super::*;

    fn cusum() -> Cusum<f64> {
        Cusum::new(&CusumSettings { threshold: 2.0, drift: 1.0, cap: 10.0 })
    }

    #[test]
    fn the_decision_function_is_eq_27() {
        let mut cusum = cusum();
        let values: Vec<f64> = [0.5, 2.0, 2.5, 0.0, 0.0, 0.0].map(|s| cusum.update(s).0).to_vec();
        assert_eq!(values, [0.0, 1.0, 2.5, 1.5, 0.5, 0.0]);
    }

    #[test]
    fn the_cap_bounds_the_time_to_fall() {
        let mut cusum = cusum();
        assert_eq!(cusum.update(225.0), (10.0, true));
        let samples = (1..).find(|_| !cusum.update(0.0).1);
        assert_eq!(samples, Some(8), "from the cap to the threshold at one drift a sample");
    }

    #[test]
    fn a_cap_below_the_threshold_is_refused() {
        let settings = CusumSettings { threshold: 2.0, drift: 1.0, cap: 1.0 };
        assert_eq!(settings.validate().expect_err("cap").name, "detector.cap");
    }

    #[test]
    fn a_decision_that_is_not_accumulated_ignores_the_samples_before() {
        let mut cusum = cusum();
        assert_eq!(
            [4.0, 2.0, 0.5, 225.0].map(|s| cusum.hold(s)),
            [(3.0, true), (1.0, false), (0.0, false), (10.0, true)]
        );
    }

    #[test]
    fn a_decision_at_the_threshold_is_not_above_it() {
        assert_eq!(cusum().update(3.0), (2.0, false));
        assert_eq!(cusum().hold(3.0), (2.0, false));
    }

    #[test]
    fn a_reset_sets_the_decision_to_0_only_in_the_masked_lanes() {
        let mut cusum = cusum();
        cusum.update(6.0);
        cusum.reset(false);
        assert_eq!(cusum.update(1.0).0, 5.0);
        cusum.reset(true);
        assert_eq!(cusum.update(1.5).0, 0.5);
    }

    #[test]
    fn another_threshold_and_cap_replace_the_configured_ones() {
        let mut cusum = cusum();
        cusum.set_thresholds(5.0, 7.0);
        assert_eq!([5.5, 2.0, 9.0].map(|s| cusum.update(s)), [(4.5, false), (5.5, true), (7.0, true)]);
    }
}
