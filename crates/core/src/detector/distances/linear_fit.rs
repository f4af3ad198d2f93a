use super::super::DetectorInput;
use super::super::hypotheses::Hypotheses;
use super::{BuiltIn, Distance, DistanceSettings};
use crate::lane::Lane;

const WINDOW_S: f64 = 20e-3;

const MIN_SAMPLES: usize = 4;
const MAX_SAMPLES: usize = 64;

/// `s_k = (y_k - ŷ_k)²` in N² for a force below `ŷ_k`, else 0; `ŷ_k` extrapolates the least-squares line through 20 ms.
#[derive(Debug, Clone)]
pub struct LinearFit<L> {
    window: [L; MAX_SAMPLES],
    length: usize,
    newest: usize,
    samples: usize,
}

impl<L: Lane> BuiltIn for LinearFit<L> {
    const UNIT: &'static str = "N²";
    const IS_BASELINE: bool = true;

    fn tuning(hypotheses: &Hypotheses) -> (f64, f64) {
        hypotheses.squared_tuning()
    }

    fn new(_settings: &DistanceSettings, tick_s: f64) -> Self {
        let length = (libm::round(WINDOW_S / tick_s) as usize).clamp(MIN_SAMPLES, MAX_SAMPLES);
        Self { window: [L::zero(); MAX_SAMPLES], length, newest: 0, samples: 0 }
    }
}

impl<L: Lane> LinearFit<L> {
    #[inline(always)]
    fn prediction(&self) -> L {
        let count = self.length as f64;
        let middle = 0.5 * (count - 1.0);
        let (mut sum, mut moment) = (L::zero(), L::zero());
        for age in 0..self.length {
            let force = self.window[(self.newest + self.length - age) % self.length];
            sum = sum + force;
            moment = moment + force * L::splat(middle - age as f64);
        }
        let spread = count * (count * count - 1.0) / 12.0;
        sum * L::splat(1.0 / count) + moment * L::splat((middle + 1.0) / spread)
    }
}

impl<L: Lane> Distance<L> for LinearFit<L> {
    #[inline(always)]
    fn update(&mut self, input: &DetectorInput<L>) -> L {
        let is_full = self.samples >= self.length;
        let excess = if is_full { input.force_n - self.prediction() } else { L::zero() };
        self.newest = (self.newest + 1) % self.length;
        self.window[self.newest] = input.force_n;
        self.samples += usize::from(!is_full);
        let fall = excess.min(L::zero());
        fall * fall
    }
}

crate::lane::gather!(LinearFit { window } same { length, newest, samples } stored);

#[cfg(test)]
mod tests {
    use super::super::super::fixtures::with_force;
    use super::*;

    #[test]
    fn a_straight_line_has_distance_0_and_a_drop_its_square() {
        let mut fit = LinearFit::<f64>::new(&DistanceSettings::DEFAULT, 1e-3);
        let mut at = |force_n: f64| fit.update(&with_force(force_n));
        for sample in 0..50 {
            assert!(at(3.0 + 0.01 * f64::from(sample)) < 1e-20, "{sample}");
        }
        assert!((at(3.5 - 0.4) - 0.16).abs() < 1e-12);
    }

    #[test]
    fn the_window_is_20_ms_within_its_bounds() {
        let length = |tick_s| LinearFit::<f64>::new(&DistanceSettings::DEFAULT, tick_s).length;
        assert_eq!([1e-3, 2e-3, 0.1, 1e-5].map(length), [20, 10, MIN_SAMPLES, MAX_SAMPLES]);
    }

    #[test]
    fn an_outlier_moves_the_line_by_its_least_squares_weight() {
        // The weight of a sample of age a in the prediction from n samples is 1/n + (m + 1)(m - a)/S, with m = (n-1)/2
        // and S = n(n²-1)/12. At n = 20: 1/20 + 10.5 (9.5 - a)/665.
        for age in [0, 3, 19] {
            let mut fit = LinearFit::<f64>::new(&DistanceSettings::DEFAULT, 1e-3);
            for sample in 0..40 {
                fit.update(&with_force(if sample == 39 - age { 1.0 } else { 0.0 }));
            }
            let weight = 1.0 / 20.0 + 10.5 * (9.5 - f64::from(age)) / 665.0;
            let fall = (-1.0 - weight).min(0.0);
            let distance = fit.update(&with_force(-1.0));
            assert!((distance - fall * fall).abs() < 1e-12, "{age}: {distance}");
        }
    }

    #[test]
    fn the_distance_is_0_for_a_rise_and_before_the_window_is_full() {
        let mut fit = LinearFit::<f64>::new(&DistanceSettings::DEFAULT, 1e-3);
        let mut at = |force_n| fit.update(&with_force(force_n));
        let filling: Vec<f64> = (0..20).map(|sample| at(-f64::from(sample % 3))).collect();
        assert_eq!(filling, [0.0; 20]);
        assert!(at(-9.0) > 0.0, "the window is full");
        assert_eq!(at(9.0), 0.0, "a rise");
    }
}
