use schemars::JsonSchema;
use serde::Serialize;

use trocar_base::quantiles::normal_quantile;

/// The number of trials, and of trials in which the operator noticed something.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, JsonSchema)]
pub struct Noticed {
    /// Number of trials.
    pub trials: u64,
    /// Number of trials in which the operator noticed something.
    pub noticed: u64,
}

impl Noticed {
    pub fn share(&self) -> Option<f64> {
        (self.trials > 0).then(|| self.noticed as f64 / self.trials as f64)
    }

    /// Half a trial added to both answers keeps the share between 0 and 1 (Hautus 1995).
    fn log_linear_share(&self) -> f64 {
        (self.noticed as f64 + 0.5) / (self.trials as f64 + 1.0)
    }
}

/// `d' = Φ⁻¹(H) - Φ⁻¹(F)` with its standard error.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub struct Sensitivity {
    /// d'.
    pub d_prime: f64,
    /// Standard error of d' (Gourevitch and Galanter 1967).
    pub std_error: f64,
}

impl Sensitivity {
    /// `None` without trials of either kind.
    pub fn of(signals: &Noticed, others: &Noticed) -> Option<Self> {
        if signals.trials == 0 || others.trials == 0 {
            return None;
        }
        let quantile = |of: &Noticed| normal_quantile(of.log_linear_share());
        let variance = |of: &Noticed| {
            let (share, z) = (of.log_linear_share(), quantile(of));
            let density = (-0.5 * z * z).exp() / (2.0 * std::f64::consts::PI).sqrt();
            share * (1.0 - share) / (of.trials as f64 * density * density)
        };
        let std_error = (variance(signals) + variance(others)).sqrt();
        Some(Self { d_prime: quantile(signals) - quantile(others), std_error })
    }

    pub fn is_none(&self) -> bool {
        self.d_prime.abs() <= -normal_quantile(0.025) * self.std_error
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_shares_have_no_sensitivity_and_known_shares_a_known_one() {
        let of = |noticed: u64| Noticed { trials: 10_000, noticed };
        let same = Sensitivity::of(&of(4_000), &of(4_030)).expect("trials");
        assert!(same.is_none(), "{same:?}");
        // Φ(1) = 0.8413 and Φ(-1) = 0.1587.
        let two = Sensitivity::of(&of(8_413), &of(1_587)).expect("trials");
        assert!((two.d_prime - 2.0).abs() < 0.002 && !two.is_none(), "{two:?}");
        assert_eq!(Sensitivity::of(&of(1), &Noticed::default()), None);
        let never = Sensitivity::of(&of(10_000), &of(0)).expect("trials");
        assert!(never.d_prime.is_finite() && never.d_prime > 7.0);
    }
}
