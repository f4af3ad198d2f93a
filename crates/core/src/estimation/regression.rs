use super::forgetting::Exponential;
use super::resetting::{Resetting, dot};
use super::settings::{Forgetting, RlsSettings};
use crate::lane::{Lane, Mask, by_index};

/// The parameters `θ` of a force `y = φᵀθ` (eq. 7, 12-18). For `φ = (p, v)` identical to [`super::Rls`], bit for bit.
#[derive(Debug, Clone)]
pub(super) struct Regression<L, const N: usize> {
    normalisation: L,
    /// In N; negative without a dead zone.
    dead_zone: L,
    dead_zone_slope: L,
    dead_zone_offset: L,
    memory: Memory<L, N>,
    parameters: [L; N],
    regressor: [L; N],
    predicted: L,
}

#[derive(Debug, Clone)]
enum Memory<L, const N: usize> {
    Resetting(Resetting<L, N>),
    Exponential(Exponential<L, N>),
}

#[derive(Debug, Clone, Copy)]
pub(super) struct RegressionUpdate<L, const N: usize> {
    /// `φᵀθ` before the sample.
    pub(super) predicted_force_n: L,
    pub(super) residual_n: L,
    pub(super) correction: [L; N],
}

impl<L: Lane, const N: usize> Regression<L, N> {
    pub(super) fn new(settings: &RlsSettings) -> Self {
        let without_dead_zone = settings.dead_zone_n == 0.0;
        Self {
            normalisation: L::splat(settings.normalisation),
            dead_zone: L::splat(if without_dead_zone { -1.0 } else { settings.dead_zone_n }),
            dead_zone_slope: L::splat(if without_dead_zone { 0.0 } else { 1.0 / settings.dead_zone_n }),
            dead_zone_offset: L::splat(if without_dead_zone { 1.0 } else { -1.0 }),
            memory: match settings.forgetting {
                Forgetting::Resetting => Memory::Resetting(Resetting::new(settings)),
                Forgetting::Exponential { factor } => Memory::Exponential(Exponential::new(settings, factor)),
            },
            parameters: [L::zero(); N],
            regressor: [L::zero(); N],
            predicted: L::zero(),
        }
    }

    #[inline(always)]
    pub(super) fn update(&mut self, force_n: L) -> RegressionUpdate<L, N> {
        let predicted_force_n = self.predicted;
        let residual_n = force_n - predicted_force_n;
        let outside = residual_n.abs().gt(self.dead_zone);
        let correction = if outside.any() { self.correct(outside, residual_n) } else { [L::zero(); N] };
        RegressionUpdate { predicted_force_n, residual_n, correction }
    }

    #[inline(always)]
    pub(super) fn set_regressor(&mut self, regressor: [L; N]) {
        self.regressor = regressor;
        self.predicted = dot(regressor, self.parameters);
    }

    #[inline(always)]
    fn correct(&mut self, outside: L::Mask, residual: L) -> [L; N] {
        let (zero, one) = (L::zero(), L::splat(1.0));
        let ramp = (residual.abs() * self.dead_zone_slope + self.dead_zone_offset).clamp(zero, one);
        let delta = L::select(outside, ramp, zero);
        let squared = dot(self.regressor, self.regressor);
        let inverse_weight = one + self.normalisation * squared;
        let (direction, share) = match &mut self.memory {
            Memory::Resetting(memory) => memory.update(self.regressor, delta, squared, inverse_weight),
            // Without a regressor nothing is forgotten.
            Memory::Exponential(memory) => {
                let delta = L::select(squared.gt(zero), delta, zero);
                memory.update(self.regressor, delta, inverse_weight)
            }
        };
        let correction: [L; N] = by_index!(N, |i| share * (direction[i] * residual));
        self.parameters = by_index!(N, |i| self.parameters[i] + correction[i]);
        correction
    }

    #[inline(always)]
    pub(super) fn parameters(&self) -> [L; N] {
        self.parameters
    }

    #[inline(always)]
    pub(super) fn regressor(&self) -> [L; N] {
        self.regressor
    }

    #[cfg(test)]
    pub(super) fn gain(&self) -> [[L; N]; N] {
        match &self.memory {
            Memory::Resetting(memory) => memory.gain(),
            Memory::Exponential(memory) => memory.gain(),
        }
    }
}

crate::lane::gather!(Regression[N] {
    normalisation, dead_zone, dead_zone_slope, dead_zone_offset, memory, parameters, regressor, predicted,
} stored);
crate::lane::gather_variants!(Memory[N] { Resetting, Exponential } stored);

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimation::{Estimator, Rls};

    fn noise(state: &mut u64) -> f64 {
        *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (*state >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }

    #[test]
    fn with_two_regressors_the_regression_equals_the_papers_estimator_to_the_last_bit() {
        let settings = RlsSettings::default();
        let (mut rls, mut regression) = (Rls::<f64>::new(&settings), Regression::<f64, 2>::new(&settings));
        let mut state = 1;
        for k in 0..5000 {
            let (p, v) = (0.01 + 0.015 * (1e-2 * f64::from(k)).sin(), 0.05 * noise(&mut state));
            let force = 200.0 * p.max(0.0) + noise(&mut state);
            let estimate = rls.update(force, p, v);
            let update = regression.update(force);
            regression.set_regressor(if p > 0.0 { [p, v] } else { [0.0; 2] });
            assert_eq!((estimate.residual_n, estimate.correction), (update.residual_n, update.correction), "{k}");
            assert_eq!([estimate.stiffness_n_per_m, estimate.damping_n_s_per_m], regression.parameters());
        }
    }

    /// The smallest and the largest value of `uᵀFu` over unit vectors `u` of random directions.
    fn range(gain: [[f64; 3]; 3], state: &mut u64) -> (f64, f64) {
        let mut range = (f64::INFINITY, 0.0_f64);
        for _ in 0..200 {
            let u: [f64; 3] = core::array::from_fn(|_| noise(state));
            let form = crate::estimation::forgetting::form(gain, u) / dot(u, u);
            range = (range.0.min(form), range.1.max(form));
        }
        range
    }

    #[test]
    fn the_gain_stays_within_its_bounds_without_excitation() {
        for factor in [0.0, 0.5, 0.9, 0.999, crate::estimation::MAX_FORGETTING_FACTOR] {
            let settings = RlsSettings {
                forgetting: Forgetting::Exponential { factor },
                dead_zone_n: 0.0,
                ..RlsSettings::default()
            };
            let min_gain = 1.0 / (1.0 / settings.initial_gain + 1.0 / (settings.normalisation * (1.0 - factor)));
            let mut regression = Regression::<f64, 3>::new(&settings);
            let mut state = 7;
            for k in 0..200_000 {
                regression.update(noise(&mut state));
                // A needle at rest, with occasional short pushes.
                let pushed = if k % 50_000 < 20 { 1e-3 * noise(&mut state) } else { 0.0 };
                regression.set_regressor([0.02 + pushed, 3.0 * pushed, 1e-3 * f64::from(pushed > 0.0)]);
                if k % 10_000 == 0 || k == 199_999 {
                    let gain = regression.gain();
                    let (low, high) = range(gain, &mut state);
                    let slack = 1e-6;
                    assert!(low >= min_gain * (1.0 - slack), "{factor} at {k}: {low} below {min_gain}");
                    assert!(high <= settings.initial_gain * (1.0 + slack), "{factor} at {k}: {high}");
                }
            }
        }
    }

    #[test]
    fn without_excitation_the_gain_returns_to_its_initial_value() {
        let forgetting = Forgetting::Exponential { factor: 0.9 };
        let settings = RlsSettings { forgetting, dead_zone_n: 0.0, ..RlsSettings::default() };
        let mut regression = Regression::<f64, 2>::new(&settings);
        let mut learn = |regressor: [f64; 2], times: u32| {
            for _ in 0..times {
                regression.set_regressor(regressor);
                regression.update(1.0);
            }
            regression.gain()
        };
        let moved = learn([0.01, 0.01], 300);
        assert!(moved[0][0] < 0.6 * settings.initial_gain && moved[0][1] < 0.0, "{moved:?}");
        let held = learn([0.01, 0.0], 300);
        assert!((held[1][1] / settings.initial_gain - 1.0).abs() < 1e-9, "{held:?}");
        // F = 1 / (1/F_0 + (α φ²)/(1-λ)), with α φ² = φ² / (1 + β φ²).
        let predicted = 1.0 / (1.0 / settings.initial_gain + 0.01_f64.powi(2) / (1.0 + 1e6 * 1e-4) / 0.1);
        assert!((held[0][0] / predicted - 1.0).abs() < 1e-9, "{held:?} {predicted}");
    }
}
