use crate::lane::Lane;

/// Of the order of an insertion between two ruptures. Chosen here.
const MEMORY_S: f64 = 0.1;

/// N/m and N·s/m. Chosen here, wider than the tissues of this project.
const PRIOR_STD: [f64; 2] = [1e3, 100.0];

/// For finite standard errors.
const MIN_VARIANCE_N2: f64 = 1e-12;

/// Confidence in an estimate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Trust {
    /// Of K.
    pub stiffness_std_n_per_m: f64,
    /// Of B.
    pub damping_std_n_s_per_m: f64,
    /// Share, 0 to 1, of the information about B that does not depend on K.
    pub excitation: f64,
}

impl Trust {
    /// Sum of 1 if 0 is within two standard errors of K, 2 if of B, 4 if one is negative.
    #[inline]
    #[must_use]
    pub fn flags(&self, stiffness_n_per_m: f64, damping_n_s_per_m: f64) -> u8 {
        let is_uncertain = |value: f64, std: f64| Lane::abs(value) <= 2.0 * std;
        let is_negative = stiffness_n_per_m < 0.0 || damping_n_s_per_m < 0.0;
        u8::from(is_uncertain(stiffness_n_per_m, self.stiffness_std_n_per_m))
            + 2 * u8::from(is_uncertain(damping_n_s_per_m, self.damping_std_n_s_per_m))
            + 4 * u8::from(is_negative)
    }
}

/// The information about `θ = (K, B)` of `y = φᵀθ`, `φ = (p, v)`; a sample `t` ago weighs `w = exp(-t/0.1 s)`:
///
/// ```text
/// M = Σ w φ φᵀ,   M₂ = Σ w² φ φᵀ,   σ² = Σ w e² / Σ w,   A = M + σ² P₀⁻¹
/// cov θ = A⁻¹ (σ² M₂ + σ⁴ P₀⁻¹) A⁻¹,   excitation = 1 - M₀₁² / (M₀₀ M₁₁)
/// ```
/// Weighted least squares with a prior `P₀`. `e` is the prediction error, so a wrong model increases the covariance.
#[derive(Debug, Clone, PartialEq)]
pub struct Confidence {
    decay: f64,
    information: [f64; 3],
    squared_weights: [f64; 3],
    squared_error: f64,
    weight: f64,
}

impl Confidence {
    /// Without samples, for ticks of `tick_s`.
    #[must_use]
    pub fn new(tick_s: f64) -> Self {
        let nothing = [0.0; 3];
        let decay = libm::exp(-tick_s / MEMORY_S);
        Self { decay, information: nothing, squared_weights: nothing, squared_error: 0.0, weight: 0.0 }
    }

    /// Adds a sample in contact: depth (m), velocity (m/s), prediction error (N).
    #[inline]
    pub fn add(&mut self, depth_m: f64, velocity_m_per_s: f64, residual_n: f64) {
        let (p, v, decay) = (depth_m, velocity_m_per_s, self.decay);
        for (index, product) in [p * p, p * v, v * v].iter().enumerate() {
            self.information[index] = decay * self.information[index] + product;
            self.squared_weights[index] = decay * decay * self.squared_weights[index] + product;
        }
        self.squared_error = decay * self.squared_error + residual_n * residual_n;
        self.weight = decay * self.weight + 1.0;
    }

    /// After the samples so far.
    #[inline]
    #[must_use]
    pub fn trust(&self) -> Trust {
        let variance = if self.weight > 0.0 { self.squared_error / self.weight } else { 0.0 };
        let variance = Lane::max(variance, MIN_VARIANCE_N2);
        let prior = [1.0 / (PRIOR_STD[0] * PRIOR_STD[0]), 1.0 / (PRIOR_STD[1] * PRIOR_STD[1])];
        let [m00, m01, m11] = self.information;
        let [s00, s01, s11] = self.squared_weights;
        let (a00, a01, a11) = (m00 + variance * prior[0], m01, m11 + variance * prior[1]);
        let determinant = a00 * a11 - a01 * a01;
        let (i00, i01, i11) = (a11 / determinant, -a01 / determinant, a00 / determinant);
        let (b00, b01, b11) = (s00 + variance * prior[0], s01, s11 + variance * prior[1]);
        let of = |x: f64, y: f64| variance * (x * x * b00 + 2.0 * x * y * b01 + y * y * b11);
        let excitation = if m00 > 0.0 && m11 > 0.0 { (1.0 - m01 * m01 / (m00 * m11)).clamp(0.0, 1.0) } else { 0.0 };
        Trust {
            stiffness_std_n_per_m: Lane::sqrt(Lane::max(of(i00, i01), 0.0)),
            damping_std_n_s_per_m: Lane::sqrt(Lane::max(of(i01, i11), 0.0)),
            excitation,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A sequence with mean 0 and variance 1, uniformly distributed and nearly uncorrelated.
    struct Noise(u64);

    impl Noise {
        fn next(&mut self) -> f64 {
            self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            12.0_f64.sqrt() * ((self.0 >> 11) as f64 / (1_u64 << 53) as f64 - 0.5)
        }
    }

    fn motion(k: u32) -> (f64, f64) {
        let t = 1e-3 * f64::from(k);
        (0.01 + 2e-3 * (30.0 * t).sin(), 0.06 * (30.0 * t).cos())
    }

    #[test]
    fn the_standard_errors_match_the_scatter_of_least_squares_over_many_seeds() {
        let (stiffness, damping, sigma) = (300.0, 4.0, 0.05);
        let decay = (-1e-3_f64 / MEMORY_S).exp();
        let (mut sums, mut trust, seeds) = ([0.0; 2], None, 2000);
        for seed in 1..=seeds {
            let (mut noise, mut confidence) = (Noise(seed * 7919), Confidence::new(1e-3));
            let (mut m, mut b) = ([0.0; 3], [0.0; 2]);
            for k in 0..800 {
                let (p, v) = motion(k);
                let error = sigma * noise.next();
                let y = stiffness * p + damping * v + error;
                confidence.add(p, v, error);
                m = [decay * m[0] + p * p, decay * m[1] + p * v, decay * m[2] + v * v];
                b = [decay * b[0] + p * y, decay * b[1] + v * y];
            }
            let determinant = m[0] * m[2] - m[1] * m[1];
            let found = [(m[2] * b[0] - m[1] * b[1]) / determinant, (m[0] * b[1] - m[1] * b[0]) / determinant];
            sums[0] += (found[0] - stiffness).powi(2);
            sums[1] += (found[1] - damping).powi(2);
            trust = Some(confidence.trust());
        }
        let trust = trust.expect("some seeds");
        let found = sums.map(|sum| (sum / seeds as f64).sqrt());
        // The last seed alone estimates the variance within a few per cent.
        assert!((found[0] / trust.stiffness_std_n_per_m - 1.0).abs() < 0.15, "{found:?} {trust:?}");
        assert!((found[1] / trust.damping_std_n_s_per_m - 1.0).abs() < 0.15, "{found:?} {trust:?}");
        assert!(trust.excitation > 0.8, "{trust:?}");
        assert_eq!(trust.flags(stiffness, damping), 0);
    }

    #[test]
    fn at_rest_damping_is_not_identified_and_its_error_is_the_prior_error() {
        let mut confidence = Confidence::new(1e-3);
        let before = confidence.trust();
        assert_eq!([before.stiffness_std_n_per_m, before.damping_std_n_s_per_m].map(f64::round), PRIOR_STD);
        for k in 0..3000 {
            confidence.add(0.01, 0.0, if k % 2 == 0 { 0.05 } else { -0.05 });
        }
        let trust = confidence.trust();
        assert_eq!(trust.excitation, 0.0);
        assert!((trust.damping_std_n_s_per_m / PRIOR_STD[1] - 1.0).abs() < 1e-9, "{trust:?}");
        assert!(trust.stiffness_std_n_per_m < 1.0, "{trust:?}");
        assert_eq!((trust.flags(300.0, 5.0), trust.flags(300.0, -100.0), trust.flags(0.1, 5.0)), (2, 6, 3));
    }
}
