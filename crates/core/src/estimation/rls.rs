use super::Parameters;
use super::estimator::{BuiltIn, Estimate, Estimator};
use super::settings::RlsSettings;
use crate::lane::{Lane, Mask};

/// Largest `F_0 α_0`, a bound of the ratio of `F`'s eigenvalues, without checks for rounding.
const WELL_CONDITIONED: f64 = 1e4;

/// Relative to `F₀₀ F₁₁`.
const MIN_DETERMINANT: f64 = 1e-12;

/// `θ = (K, B)` of the force `y = K p + B v`:
///
/// ```text
/// e_k = y_k - φ_{k-1}ᵀ θ_{k-1}                                  (7)
/// d_k = 1/α_{k-1} + φ_{k-1}ᵀ F_{k-1} φ_{k-1}
/// θ_k = θ_{k-1} + δ(e_k) F_{k-1} φ_{k-1} e_k / d_k              (12, 15)
/// F_k = F_{k-1} - δ(e_k) F_{k-1} φ_{k-1} φ_{k-1}ᵀ F_{k-1} / d_k (13, 15)
/// x_k = x_{k-1} + δ(e_k) α_{k-1} φ_{k-1}ᵀ φ_{k-1}               (18)
/// x_k >= α_0:  F_k = F_0, x_k = tr(F_0⁻¹)                       (17)
/// 1/α_k = 1 + β φ_kᵀ φ_k                                        (14)
/// ```
/// with `φ_k = (p_k, v_k)` in contact (`p_k > 0`) and 0 outside. Another reading of eq. 15, `δ F`, would end all
/// adaptation at the first small error.
///
/// An update adds at most `δ α φφᵀ` to `F⁻¹`, so the eigenvalues of `F` lie between `1/α_0` and `F_0`. Rounding adds up
/// to `n 2⁻⁵¹ F_0` over `n` corrections: with `F_0 α_0 <= 10⁴` (default: 102) `F` stays definite for over 10¹¹;
/// otherwise each correction checks it, and restores `F_0`.
///
/// Adjacent fields must not both be written at one sample and read at the next: the compiler would read them as a pair,
/// which stalls until both writes have left the store buffer.
#[derive(Debug, Clone)]
#[repr(C)]
pub struct Rls<L> {
    stiffness: L,
    gain_01: L,
    depth: L,
    damping: L,
    gain_00: L,
    predicted_force: L,
    velocity: L,
    information: L,
    gain_11: L,
    initial_gain: L,
    initial_information: L,
    reset_threshold: L,
    checks_definiteness: bool,
    normalisation: L,
    /// 0 without damping.
    velocity_share: L,
    /// In N; negative without a dead zone.
    dead_zone: L,
    dead_zone_slope: L,
    dead_zone_offset: L,
}

impl<L: Lane> Rls<L> {
    /// Starts with `θ = 0`, `F = F_0`.
    #[must_use]
    pub fn new(settings: &RlsSettings) -> Self {
        let information = 2.0 / settings.initial_gain;
        let without_dead_zone = settings.dead_zone_n == 0.0;
        Self {
            stiffness: L::zero(),
            gain_01: L::zero(),
            depth: L::zero(),
            damping: L::zero(),
            gain_00: L::splat(settings.initial_gain),
            predicted_force: L::zero(),
            velocity: L::zero(),
            information: L::splat(information),
            gain_11: L::splat(settings.initial_gain),
            initial_gain: L::splat(settings.initial_gain),
            initial_information: L::splat(information),
            reset_threshold: L::splat(settings.reset_threshold),
            checks_definiteness: settings.initial_gain * settings.reset_threshold > WELL_CONDITIONED,
            normalisation: L::splat(settings.normalisation),
            velocity_share: L::splat(if settings.parameters == Parameters::Stiffness { 0.0 } else { 1.0 }),
            dead_zone: L::splat(if without_dead_zone { -1.0 } else { settings.dead_zone_n }),
            dead_zone_slope: L::splat(if without_dead_zone { 0.0 } else { 1.0 / settings.dead_zone_n }),
            dead_zone_offset: L::splat(if without_dead_zone { 1.0 } else { -1.0 }),
        }
    }

    #[inline(always)]
    fn correct(&mut self, outside: L::Mask, residual: L) -> [L; 2] {
        let (zero, one) = (L::zero(), L::splat(1.0));
        let ramp = (residual.abs() * self.dead_zone_slope + self.dead_zone_offset).clamp(zero, one);
        let delta = L::select(outside, ramp, zero);
        let (p, v) = (self.depth, self.velocity);
        let [f00, f01, f11] = self.gain();
        let squared_regressor = p * p + v * v;
        let inverse_weight = L::splat(1.0) + self.normalisation * squared_regressor;
        let q0 = f00 * p + f01 * v;
        let q1 = f01 * p + f11 * v;
        let share = delta * (one / (inverse_weight + (p * q0 + v * q1)));
        let correction = [share * (q0 * residual), share * (q1 * residual)];
        self.stiffness = self.stiffness + correction[0];
        self.damping = self.damping + correction[1];
        self.gain_00 = f00 - share * (q0 * q0);
        self.gain_01 = f01 - share * (q0 * q1);
        self.gain_11 = f11 - share * (q1 * q1);
        self.information = self.information + delta * (squared_regressor / inverse_weight);
        let mut restore = self.information.ge(self.reset_threshold);
        if self.checks_definiteness {
            restore = restore | !self.is_definite();
        }
        if restore.any() {
            self.restore(restore);
        }
        correction
    }

    /// By more than rounding errors.
    #[inline(always)]
    fn is_definite(&self) -> L::Mask {
        let [f00, f01, f11] = self.gain();
        let product = f00 * f11;
        (product - f01 * f01).gt(L::splat(MIN_DETERMINANT) * product)
    }

    /// The gain `F`, symmetric, as (F₀₀, F₀₁, F₁₁).
    #[inline(always)]
    #[must_use]
    pub fn gain(&self) -> [L; 3] {
        [self.gain_00, self.gain_01, self.gain_11]
    }

    #[inline(always)]
    fn restore(&mut self, mask: L::Mask) {
        self.gain_00 = L::select(mask, self.initial_gain, self.gain_00);
        self.gain_01 = L::select(mask, L::zero(), self.gain_01);
        self.gain_11 = L::select(mask, self.initial_gain, self.gain_11);
        self.information = L::select(mask, self.initial_information, self.information);
    }
}

impl<L: Lane> BuiltIn for Rls<L> {
    const IS_BASELINE: bool = true;

    fn build(settings: &RlsSettings) -> Self {
        Self::new(settings)
    }
}

impl<L: Lane> Estimator<L> for Rls<L> {
    #[inline(always)]
    fn update(&mut self, force_n: L, depth_m: L, velocity_m_per_s: L) -> Estimate<L> {
        let zero = L::zero();
        let predicted = self.predicted_force;
        let residual = force_n - predicted;

        // Fast path: most samples are within the dead zone, and the branch saves two divisions; with several lanes
        // mispredictions cost more.
        let outside = residual.abs().gt(self.dead_zone);
        let correction = if L::WIDTH > 1 || outside.any() { self.correct(outside, residual) } else { [zero; 2] };

        let contact = depth_m.gt(zero);
        let velocity = self.velocity_share * velocity_m_per_s;
        let (p, v) = (L::select(contact, depth_m, zero), L::select(contact, velocity, zero));
        (self.depth, self.velocity) = (p, v);
        self.predicted_force = p * self.stiffness + v * self.damping;
        Estimate {
            predicted_force_n: predicted,
            residual_n: residual,
            correction,
            stiffness_n_per_m: self.stiffness,
            damping_n_s_per_m: self.damping,
            extra_parameter: zero,
        }
    }

    #[inline(always)]
    fn skip(&mut self) {
        (self.depth, self.velocity, self.predicted_force) = (L::zero(), L::zero(), L::zero());
    }
}

crate::lane::gather!(Rls {
    initial_gain, initial_information, reset_threshold, normalisation, velocity_share, dead_zone, dead_zone_slope,
    dead_zone_offset, stiffness, damping, gain_00, gain_01, gain_11, information, depth, velocity, predicted_force,
} same { checks_definiteness } stored);

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns depth and velocity of an insertion with a ripple that excites both parameters.
    fn insertion(k: u32) -> (f64, f64) {
        let t = f64::from(k) * 1e-3;
        (5e-3 + 0.01 * t + 2e-3 * (40.0 * t).sin(), 0.01 + 0.08 * (40.0 * t).cos())
    }

    #[test]
    fn constant_parameters_are_found() {
        let mut rls = Rls::<f64>::new(&RlsSettings { dead_zone_n: 0.0, ..RlsSettings::default() });
        let (mut p, mut v) = (0.0, 0.0);
        for k in 0..4000 {
            let force = 350.0 * p + 12.0 * v;
            (p, v) = insertion(k);
            rls.update(force, p, v);
        }
        let last = rls.update(350.0 * p + 12.0 * v, p, v);
        assert!((last.stiffness_n_per_m - 350.0).abs() < 1e-3, "{last:?}");
        assert!((last.damping_n_s_per_m - 12.0).abs() < 1e-2, "{last:?}");
    }

    #[test]
    fn the_dead_zone_is_eq_15() {
        let settings = RlsSettings {
            dead_zone_n: 0.1,
            normalisation: 0.0,
            initial_gain: 1e4,
            reset_threshold: 1.0,
            ..RlsSettings::default()
        };
        let correction = |error: f64| {
            let mut rls = Rls::<f64>::new(&settings);
            rls.update(0.0, 0.01, 0.0);
            rls.update(error, 0.01, 0.0).correction[0]
        };
        let full = correction(0.4) / 0.4;
        assert_eq!(correction(0.0999), 0.0);
        assert!((correction(0.15) / 0.15 - 0.5 * full).abs() < 1e-9 * full, "halfway up the ramp");
        assert!((correction(0.2) / 0.2 - full).abs() < 1e-9 * full);
    }

    #[test]
    fn the_dead_zone_does_not_end_the_adaptation() {
        let mut rls = Rls::<f64>::new(&RlsSettings::default());
        for _ in 0..100 {
            rls.update(0.001, 0.02, 0.005);
        }
        let after_error = rls.update(4.0, 0.02, 0.005);
        assert!(after_error.stiffness_n_per_m > 100.0, "{after_error:?}");
    }

    #[test]
    fn with_normalisation_the_correction_does_not_depend_on_depth() {
        let share = |depth: f64| {
            let mut rls = Rls::<f64>::new(&RlsSettings::default());
            rls.update(0.0, depth, 0.0);
            rls.update(1.0, depth, 0.0);
            rls.update(1.0, depth, 0.0).predicted_force_n
        };
        assert!((share(0.005) - 10.0 / 11.0).abs() < 0.01, "{}", share(0.005));
        assert!((share(0.1) - 10.0 / 11.0).abs() < 1e-3, "{}", share(0.1));
    }

    #[test]
    fn outside_contact_the_estimate_does_not_change() {
        let mut rls = Rls::<f64>::new(&RlsSettings::default());
        for _ in 0..50 {
            let estimate = rls.update(3.0, -1e-3, 0.1);
            assert_eq!((estimate.stiffness_n_per_m, estimate.residual_n), (0.0, 3.0));
        }
    }

    #[test]
    fn an_estimator_of_stiffness_alone_ignores_the_velocity() {
        let settings = RlsSettings { parameters: Parameters::Stiffness, ..RlsSettings::default() };
        let (mut alone, mut still) = (Rls::<f64>::new(&settings), Rls::<f64>::new(&RlsSettings::default()));
        for k in 0..1000 {
            let (p, v) = insertion(k);
            let (a, b) = (alone.update(350.0 * p + 12.0 * v, p, v), still.update(350.0 * p + 12.0 * v, p, 0.0));
            assert_eq!((a.residual_n, a.stiffness_n_per_m), (b.residual_n, b.stiffness_n_per_m));
            assert_eq!(a.damping_n_s_per_m, 0.0);
        }
    }

    fn eigenvalues(rls: &Rls<f64>) -> [f64; 2] {
        let [f00, f01, f11] = rls.gain();
        let max = f64::midpoint(f00, f11) + f64::midpoint(f00, -f11).hypot(f01);
        [(f00 * f11 - f01 * f01) / max, max]
    }

    #[test]
    fn the_gain_stays_within_its_bounds() {
        let settings = RlsSettings { dead_zone_n: 0.0, ..RlsSettings::default() };
        let mut rls = Rls::<f64>::new(&settings);
        for k in 0..100_000 {
            let (p, v) = insertion(k % 3000);
            rls.update(if k % 2 == 0 { 5.0 } else { -5.0 }, p, v);
            let [min, max] = eigenvalues(&rls);
            assert!(min > (1.0 - 1e-9) / settings.reset_threshold, "{min}");
            assert!(max <= (1.0 + 1e-12) * settings.initial_gain, "{max}");
        }
    }

    /// Without the check, `F` becomes indefinite after a thousand of these samples.
    #[test]
    fn rounding_does_not_make_the_gain_indefinite() {
        let settings = RlsSettings {
            initial_gain: 1e12,
            reset_threshold: 1e12,
            dead_zone_n: 0.0,
            normalisation: 0.0,
            ..RlsSettings::default()
        };
        let mut rls = Rls::<f64>::new(&settings);
        for k in 0..200_000 {
            let depth = 1.0 + 1e-9 * f64::from(k).sin();
            let estimate = rls.update(if k % 2 == 0 { 5.0 } else { -5.0 }, depth, 1.0);
            let [f00, f01, f11] = rls.gain();
            assert!(f00 > 0.0 && f11 > 0.0 && f01 * f01 < f00 * f11, "at {k}: {f00:e} {f01:e} {f11:e}");
            assert!(estimate.stiffness_n_per_m.is_finite() && f00.max(f11) <= 1e12);
        }
    }

    #[test]
    fn a_missing_sample_does_not_change_the_estimate() {
        let mut rls = Rls::<f64>::new(&RlsSettings::default());
        for k in 0..1000 {
            let (p, v) = insertion(k);
            rls.update(350.0 * p + 12.0 * v, p, v);
        }
        let (gain, before) = (rls.gain(), rls.update(3.0, 0.01, 0.0));
        rls.skip();
        let after = rls.update(300.0, 0.01, 0.0);
        assert_eq!((after.predicted_force_n, after.correction), (0.0, [0.0; 2]));
        assert_eq!(after.stiffness_n_per_m, before.stiffness_n_per_m);
        assert_ne!(gain, [0.0; 3]);
    }
}
