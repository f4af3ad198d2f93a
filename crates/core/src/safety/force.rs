use super::SafetySettings;
use crate::lane::Lane;

/// `F_k = clamp(clamp(F, -F_max, F_max), F_{k-1} - r T, F_{k-1} + r T)` from `F_{-1} = 0`.
#[derive(Debug, Clone)]
pub struct ForceLimiter<L> {
    limit_n: L,
    step_n: L,
    last_n: L,
}

/// A limited force.
#[derive(Debug, Clone, Copy)]
pub struct LimitedForce<L: Lane> {
    /// In N.
    pub force_n: L,
    /// Lanes beyond the limit.
    pub beyond: L::Mask,
    /// Lanes beyond the rate.
    pub too_fast: L::Mask,
}

impl<L: Lane> ForceLimiter<L> {
    /// Starts at a force of 0.
    #[must_use]
    pub fn new(settings: &SafetySettings, tick_s: f64) -> Self {
        Self {
            limit_n: L::splat(settings.force_limit_n),
            step_n: L::splat(settings.force_rate_n_per_s * tick_s),
            last_n: L::zero(),
        }
    }

    pub(super) fn continuing(self, force_n: L) -> Self {
        Self { last_n: force_n, ..self }
    }

    /// Limits the next force in N.
    #[inline(always)]
    pub fn limit(&mut self, wanted_n: L) -> LimitedForce<L> {
        let beyond = wanted_n.abs().gt(self.limit_n);
        let bounded = wanted_n.clamp(-self.limit_n, self.limit_n);
        let (low, high) = (self.last_n - self.step_n, self.last_n + self.step_n);
        let too_fast = bounded.lt(low) | bounded.gt(high);
        self.last_n = bounded.clamp(low, high);
        LimitedForce { force_n: self.last_n, beyond, too_fast }
    }
}

crate::lane::gather!(ForceLimiter { limit_n, step_n, last_n } stored);

#[cfg(test)]
mod tests {
    use super::*;

    fn limiter() -> ForceLimiter<f64> {
        let settings = SafetySettings { force_limit_n: 4.0, force_rate_n_per_s: 1000.0, ..SafetySettings::DEFAULT };
        ForceLimiter::new(&settings, 1e-3)
    }

    #[test]
    fn a_force_within_its_limits_passes_bit_for_bit() {
        let mut limiter = limiter();
        for k in 0..500 {
            let wanted = 3.3 * libm::sin(0.1 * f64::from(k));
            let limited = limiter.limit(wanted);
            assert_eq!(limited.force_n.to_bits(), wanted.to_bits(), "{k}");
            assert!(!limited.beyond && !limited.too_fast, "{k}");
        }
    }

    #[test]
    fn a_large_force_is_reached_in_steps_and_cut() {
        let mut limiter = limiter();
        let forces: Vec<f64> = (0..6).map(|_| limiter.limit(1e9).force_n).collect();
        assert_eq!(forces, [1.0, 2.0, 3.0, 4.0, 4.0, 4.0]);
        let back = limiter.limit(-1e9);
        assert_eq!((back.force_n, back.beyond, back.too_fast), (3.0, true, true));
        let within = limiter.limit(2.5);
        assert_eq!((within.force_n, within.beyond, within.too_fast), (2.5, false, false));
    }
}
