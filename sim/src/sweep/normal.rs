//! The standard normal distribution.

use core::f64::consts::FRAC_1_SQRT_2;

/// Beyond this the distribution function is 0 or 1 to the last bit.
const MAX_DEVIATION: f64 = 9.0;

/// The share of the distribution below `z`.
pub(super) fn cdf(z: f64) -> f64 {
    0.5 * libm::erfc(-z * FRAC_1_SQRT_2)
}

/// The number below which a share of the distribution lies, by bisection; within ±9.
pub(super) fn quantile(share: f64) -> f64 {
    let (mut low, mut high) = (-MAX_DEVIATION, MAX_DEVIATION);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if cdf(middle) < share {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn oracle_quantiles_of_tables() {
        for (share, z) in [(0.5, 0.0), (0.975, 1.959_963_984_540_054), (0.001, -3.090_232_306_167_813_5)] {
            assert!((quantile(share) - z).abs() < 1e-12, "{share}: {}", quantile(share));
        }
        assert!(quantile(0.0) <= -8.9 && quantile(1.0) >= 8.2);
    }
}
