use super::super::DetectorInput;
use super::super::hypotheses::Hypotheses;
use super::{BuiltIn, Distance, DistanceSettings, square};
use crate::lane::Lane;

/// The size of the buffer, because a detector allocates nothing.
pub const MAX_WINDOW_SAMPLES: usize = 64;

crate::settings! {
    /// The window of a likelihood ratio.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct WindowSettings in "detector." {
        /// Length of the likelihood ratio's window in samples, at most 64.
        ///
        /// By default the estimator's memory, after which the residual vanishes (chosen here).
        window_samples: usize [1..] = 10,
    }
    where window_samples: |s| s.window_samples <= MAX_WINDOW_SAMPLES, "a whole number from 1 to 64";
}

/// Log-likelihood ratio of a mean that shifted from 0 by an unknown size at an unknown sample:
///
/// ```text
/// T_k = max over n = 1 … N of (e_{k-n+1} + … + e_k)² / (2 σ_0² n)
/// ```
/// Dimensionless (Basseville and Nikiforov, *Detection of Abrupt Changes*, 1993, chapter 2; window: Willsky and Jones,
/// *IEEE Transactions on Automatic Control* 21, 1976); takes `N` steps per sample.
#[derive(Debug, Clone)]
pub struct LikelihoodRatio<L> {
    window: [L; MAX_WINDOW_SAMPLES],
    /// `1 / (2 σ_0² n)`.
    weight: [L; MAX_WINDOW_SAMPLES],
    samples: usize,
    newest: usize,
}

impl<L: Lane> LikelihoodRatio<L> {
    fn over(samples: usize, quiet_std_n: f64) -> Self {
        let weight = |n: usize| L::splat(1.0 / (2.0 * quiet_std_n * quiet_std_n * (n + 1) as f64));
        Self {
            window: [L::zero(); MAX_WINDOW_SAMPLES],
            weight: core::array::from_fn(weight),
            samples: samples.clamp(1, MAX_WINDOW_SAMPLES),
            newest: 0,
        }
    }

    #[inline(always)]
    fn ratio(&mut self, residual: L) -> L {
        self.newest = if self.newest + 1 < self.samples { self.newest + 1 } else { 0 };
        self.window[self.newest] = residual;
        let (recent, older) = self.window[..self.samples].split_at(self.newest + 1);
        let backwards = recent.iter().rev().chain(older.iter().rev());
        let (mut sum, mut ratio) = (L::zero(), L::zero());
        for (&sample, &weight) in backwards.zip(&self.weight) {
            sum = sum + sample;
            // In this order `max` ignores a NaN.
            ratio = (sum * sum * weight).max(ratio);
        }
        ratio
    }

    #[inline(always)]
    fn forget(&mut self, mask: L::Mask) {
        for sample in &mut self.window {
            *sample = L::select(mask, L::zero(), *sample);
        }
    }
}

impl<L: Lane> BuiltIn for LikelihoodRatio<L> {
    const UNIT: &'static str = "1";
    const ACCUMULATES: bool = false;

    fn tuning(hypotheses: &Hypotheses) -> (f64, f64) {
        (square(hypotheses.rupture_mean_n) / (2.0 * square(hypotheses.quiet_std_n)), 0.0)
    }

    fn new(settings: &DistanceSettings, _tick_s: f64) -> Self {
        Self::over(settings.window.window_samples, settings.hypotheses.quiet_std_n)
    }
}

impl<L: Lane> Distance<L> for LikelihoodRatio<L> {
    #[inline(always)]
    fn update(&mut self, input: &DetectorInput<L>) -> L {
        self.ratio(input.residual_n)
    }

    #[inline(always)]
    fn reset(&mut self, mask: L::Mask) {
        self.forget(mask);
    }

    #[inline(always)]
    fn accumulates(&self) -> bool {
        Self::ACCUMULATES
    }
}

crate::lane::gather!(LikelihoodRatio { window, weight } same { samples, newest } stored);

#[cfg(test)]
mod tests {
    use super::*;

    fn by_definition(residuals: &[f64], samples: usize, std: f64) -> f64 {
        let ratio = |n: usize| {
            let last = &residuals[residuals.len() - n..];
            let mean = last.iter().sum::<f64>() / n as f64;
            let log_likelihood = |m: f64| last.iter().map(|e| -(e - m).powi(2) / (2.0 * std * std)).sum::<f64>();
            log_likelihood(mean) - log_likelihood(0.0)
        };
        (1..=samples.min(residuals.len())).map(ratio).fold(0.0, f64::max)
    }

    #[test]
    fn the_distance_is_the_greatest_log_likelihood_ratio_over_size_and_time() {
        let residuals: Vec<f64> = (0..300).map(|k| 0.1 * f64::from(k * k % 17) / 17.0 - 0.04).collect();
        for samples in [1, 2, 10, MAX_WINDOW_SAMPLES] {
            let mut ratio = LikelihoodRatio::<f64>::over(samples, 0.02);
            for k in 0..residuals.len() {
                let expected = by_definition(&residuals[..=k], samples, 0.02);
                let got = ratio.ratio(residuals[k]);
                assert!((got - expected).abs() < 1e-9 * expected.max(1.0), "{samples}, {k}: {got} {expected}");
            }
        }
    }

    #[test]
    fn a_nan_sample_is_forgotten_with_its_window() {
        let mut ratio = LikelihoodRatio::<f64>::over(3, 0.02);
        assert_eq!(ratio.ratio(f64::NAN), 0.0);
        for _ in 0..3 {
            assert!(ratio.ratio(0.02).is_finite());
        }
        assert!((ratio.ratio(0.02) - 1.5).abs() < 1e-12);
    }

    #[test]
    fn the_length_of_the_window_is_bounded() {
        let samples = |samples| LikelihoodRatio::<f64>::over(samples, 0.02).samples;
        assert_eq!([0, 1, 64, 65].map(samples), [1, 1, 64, 64]);
        let refused = |window_samples| WindowSettings { window_samples }.validate().is_err();
        assert_eq!([0, 1, 64, 65].map(refused), [true, false, false, true]);
    }

    #[test]
    fn only_the_masked_lane_is_reset() {
        let mut ratio = LikelihoodRatio::<f64>::over(3, 0.5);
        ratio.ratio(1.0);
        ratio.reset(false);
        // `(1 + 1)² / (2 · 0.25 · 2)` over both samples, `1 / (2 · 0.25)` over one.
        assert_eq!(ratio.ratio(1.0), 4.0);
        ratio.reset(true);
        assert_eq!(ratio.ratio(1.0), 2.0);
    }
}
