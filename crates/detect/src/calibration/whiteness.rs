use schemars::JsonSchema;
use serde::Serialize;
use trocar_base::centred::Centred;

/// Lags of the Ljung-Box test; even, so that the χ² tail has a closed form.
pub const LAGS: usize = 20;

/// The results of the tests of residuals.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub struct Whiteness {
    /// Number of samples.
    pub samples: usize,
    /// Correlation of one sample with the next, -1 to 1.
    pub lag_one_correlation: f64,
    /// Statistic of Ljung and Box (1978) over 20 lags.
    pub ljung_box: f64,
    /// Probability of a statistic at least as large for a white residual, 0 to 1.
    pub ljung_box_p: f64,
    /// Third standardised moment; 0 for a Gaussian.
    pub skewness: f64,
    /// Fourth standardised moment minus 3; 0 for a Gaussian.
    pub excess_kurtosis: f64,
    /// Statistic of Jarque and Bera (1980).
    pub jarque_bera: f64,
    /// Probability of a statistic at least as large for a Gaussian residual, 0 to 1.
    pub jarque_bera_p: f64,
}

const REJECTED: f64 = 0.01;

impl Whiteness {
    pub fn is_rejected(&self) -> bool {
        self.ljung_box_p < REJECTED || self.jarque_bera_p < REJECTED
    }

    /// `None` for a constant or too few residuals.
    pub fn of(residual: &[f64]) -> Option<Self> {
        let count = residual.len() as f64;
        let centred = Centred::of(residual).filter(|_| residual.len() >= 5 * LAGS)?;
        let variance = centred.moment(2);
        let ljung_box = (1..=LAGS).map(|lag| centred.correlation(lag).powi(2) / (count - lag as f64)).sum::<f64>()
            * (count * (count + 2.0));
        let skewness = centred.moment(3) / variance.powf(1.5);
        let excess_kurtosis = centred.moment(4) / variance.powi(2) - 3.0;
        let jarque_bera = count / 6.0 * (skewness.powi(2) + excess_kurtosis.powi(2) / 4.0);
        Some(Self {
            samples: residual.len(),
            lag_one_correlation: centred.correlation(1),
            ljung_box,
            ljung_box_p: chi_square_tail(ljung_box, LAGS),
            skewness,
            excess_kurtosis,
            jarque_bera,
            jarque_bera_p: chi_square_tail(jarque_bera, 2),
        })
    }
}

/// `e^{-x/2} Σ_{k<n/2} (x/2)^k / k!`, for even degrees.
fn chi_square_tail(x: f64, degrees: usize) -> f64 {
    let half = x / 2.0;
    let mut term = (-half).exp();
    let mut sum = term;
    for k in 1..degrees / 2 {
        term *= half / k as f64;
        sum += term;
    }
    sum.min(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};

    fn noise(seed: u64, count: usize) -> Vec<f64> {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        (0..count).map(|_| StandardNormal.sample(&mut random)).collect()
    }

    #[test]
    fn white_gaussian_noise_is_rejected_at_the_rate_of_the_level() {
        let tests: Vec<Whiteness> = (0..400).filter_map(|seed| Whiteness::of(&noise(seed, 1000))).collect();
        let rejected = |p: fn(&Whiteness) -> f64| tests.iter().filter(|test| p(test) < 0.05).count();
        // 20 of 400 are expected. The bounds 7 and 35 allow for three standard deviations and for the small-sample
        // error of the tests.
        for count in [rejected(|test| test.ljung_box_p), rejected(|test| test.jarque_bera_p)] {
            assert!((7..=35).contains(&count), "{count}");
        }
    }

    #[test]
    fn residuals_that_are_not_white_or_not_gaussian_are_rejected() {
        let white = noise(1, 2000);
        let mut coloured = vec![0.0; 2000];
        for k in 1..2000 {
            coloured[k] = 0.5 * coloured[k - 1] + white[k];
        }
        let test = Whiteness::of(&coloured).expect("enough");
        assert!((test.lag_one_correlation - 0.5).abs() < 0.06 && test.ljung_box_p < 1e-6, "{test:?}");
        let cubed: Vec<f64> = white.iter().map(|x| x.powi(3)).collect();
        assert!(Whiteness::of(&cubed).expect("enough").jarque_bera_p < 1e-6);
    }

    #[test]
    fn the_tail_of_chi_square_agrees_with_tables() {
        // 5 % points of χ² with 2 and 20 degrees of freedom.
        assert!((chi_square_tail(5.991, 2) - 0.05).abs() < 1e-4);
        assert!((chi_square_tail(31.410, 20) - 0.05).abs() < 1e-4);
    }

    #[test]
    fn too_few_or_constant_samples_give_no_result() {
        assert_eq!(Whiteness::of(&noise(1, 99)), None);
        assert_eq!(Whiteness::of(&[0.3; 500]), None);
    }
}
