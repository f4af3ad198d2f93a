use super::super::DetectorInput;
use super::super::hypotheses::Hypotheses;
use super::{BuiltIn, Distance, DistanceSettings};
use crate::lane::{Lane, Mask};

/// Deviation from the mean since the start or the last alarm:
///
/// ```text
/// ē_k = ē_{k-1} + (e_k - ē_{k-1}) / k
/// s_k = ± (e_k - ē_k)
/// ```
/// in N, with the sign of `m_1` (eq. 22); with eq. 27 the Page-Hinkley test (Hinkley, *Biometrika* 58, 1971). Constant
/// model errors have no effect, but after a long quiet time a new offset counts as a change.
#[derive(Debug, Clone)]
pub struct PageHinkley<L> {
    towards: L,
    mean: L,
    samples: L,
}

impl<L: Lane> PageHinkley<L> {
    fn towards(rupture_mean_n: f64) -> Self {
        Self { towards: L::splat(rupture_mean_n.signum()), mean: L::zero(), samples: L::zero() }
    }

    /// 0 for NaN and infinite residuals.
    #[inline(always)]
    fn excess(&mut self, residual: L) -> L {
        let finite = residual.abs().le(L::splat(f64::MAX));
        let residual = L::select(finite, residual, self.mean);
        self.samples = self.samples + L::select(finite, L::splat(1.0), L::zero());
        self.mean = self.mean + (residual - self.mean) / self.samples.max(L::splat(1.0));
        self.towards * (residual - self.mean)
    }

    #[inline(always)]
    fn forget(&mut self, mask: L::Mask) {
        if mask.any() {
            self.mean = L::select(mask, L::zero(), self.mean);
            self.samples = L::select(mask, L::zero(), self.samples);
        }
    }
}

impl<L: Lane> BuiltIn for PageHinkley<L> {
    const UNIT: &'static str = "N";
    const IS_ONE_SIDED: bool = true;

    /// Half the smallest shift to detect.
    fn tuning(hypotheses: &Hypotheses) -> (f64, f64) {
        let half = hypotheses.rupture_mean_n.abs() / 2.0;
        (half, half)
    }

    fn new(settings: &DistanceSettings, _tick_s: f64) -> Self {
        Self::towards(settings.hypotheses.rupture_mean_n)
    }
}

impl<L: Lane> Distance<L> for PageHinkley<L> {
    #[inline(always)]
    fn update(&mut self, input: &DetectorInput<L>) -> L {
        self.excess(input.residual_n)
    }

    #[inline(always)]
    fn reset(&mut self, mask: L::Mask) {
        self.forget(mask);
    }
}

crate::lane::gather!(PageHinkley { towards, mean, samples } stored);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_accumulated_distance_is_the_sum_minus_its_smallest_value() {
        let residuals: Vec<f64> =
            (0..400).map(|k| 0.3 - 0.2 * f64::from(k * k % 13) / 13.0 - f64::from(k / 300)).collect();
        let drift = 0.05;
        let mut test = PageHinkley::<f64>::towards(-0.2);
        let (mut accumulated, mut sum, mut minimum) = (0.0_f64, 0.0_f64, 0.0_f64);
        for k in 0..residuals.len() {
            accumulated = (accumulated + (test.excess(residuals[k]) - drift)).max(0.0);
            let mean = residuals[..=k].iter().sum::<f64>() / (k + 1) as f64;
            sum += mean - residuals[k] - drift;
            minimum = minimum.min(sum);
            assert!((accumulated - (sum - minimum)).abs() < 1e-9, "{k}");
        }
        assert!(accumulated > 10.0, "the shift at 300 is detected: {accumulated}");
    }

    #[test]
    fn nan_and_infinity_are_ignored() {
        let mut test = PageHinkley::<f64>::towards(-0.2);
        test.excess(1.0);
        assert_eq!((test.excess(f64::NAN), test.excess(f64::INFINITY)), (0.0, 0.0));
        assert_eq!(test.excess(0.0), 0.5);
    }

    #[test]
    fn a_shift_counts_in_the_direction_of_the_mean_of_a_rupture() {
        for (mean_n, shift_n) in [(-0.2, -1.0), (0.2, 1.0)] {
            let mut test = PageHinkley::<f64>::towards(mean_n);
            test.excess(0.0);
            // The shift is measured from the mean of 0 and the shift.
            assert_eq!(test.excess(shift_n), 0.5);
        }
    }

    #[test]
    fn a_reset_restarts_the_mean_only_in_the_masked_lanes() {
        let mut test = PageHinkley::<f64>::towards(-0.2);
        for residual in [1.0; 3] {
            test.excess(residual);
        }
        test.reset(false);
        assert_eq!(test.excess(-3.0), 3.0, "the mean of 1, 1, 1 and -3 is 0");
        test.reset(true);
        assert_eq!([-4.0, -6.0].map(|e| test.excess(e)), [0.0, 1.0]);
    }
}
