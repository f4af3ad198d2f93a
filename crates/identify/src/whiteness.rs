use schemars::JsonSchema;
use serde::Serialize;
use trocar_base::centred::Centred;

const LAGS: usize = 20;

/// The correlation of a recording's residuals. A simulation that leaves white residuals explains everything but noise.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub struct Whiteness {
    /// Correlation of one residual with the next, -1 to 1.
    pub lag_one_correlation: f64,
    /// Number of lags from 1 to 20 whose correlation is within ±1.96/√n, as 95 % of those of white noise are.
    pub lags_within_bounds: usize,
}

impl Whiteness {
    /// `None` if the residuals are constant or fewer than 100.
    pub fn of(residuals: &[f64]) -> Option<Self> {
        let centred = Centred::of(residuals).filter(|_| residuals.len() >= 5 * LAGS)?;
        let bound = 1.96 / (residuals.len() as f64).sqrt();
        let lags_within_bounds = (1..=LAGS).filter(|lag| centred.correlation(*lag).abs() <= bound).count();
        Some(Self { lag_one_correlation: centred.correlation(1), lags_within_bounds })
    }

    pub(crate) fn between(simulated: &[f64], measured: &[f64]) -> Option<Self> {
        Self::of(&simulated.iter().zip(measured).map(|(simulated, measured)| simulated - measured).collect::<Vec<_>>())
    }

    /// At least 17 of the 20 lags are within their bounds, as for 98 % of white residuals.
    pub fn is_white(&self) -> bool {
        self.lags_within_bounds >= 17
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sine_is_not_white_and_a_constant_has_no_correlation() {
        let sine: Vec<f64> = (0..1000).map(|k| (f64::from(k) * 0.05).sin()).collect();
        let whiteness = Whiteness::of(&sine).expect("varies");
        assert!(!whiteness.is_white() && whiteness.lag_one_correlation > 0.99);
        assert_eq!(Whiteness::of(&[1.0; 200]), None);
    }

    #[test]
    fn noise_is_white() {
        // A full-period linear congruential generator.
        let mut state = 1_u64;
        let mut next = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 33) as f64
        };
        let noise: Vec<f64> = (0..5000).map(|_| next()).collect();
        assert!(Whiteness::of(&noise).expect("varies").is_white());
    }
}
