use super::SafetySettings;
use crate::lane::Lane;

/// `x_k = clamp(clamp(x, s - d, s + d), x_{k-1} - v T, x_{k-1} + v T)` with the slave `s`.
#[derive(Debug, Clone)]
pub struct ReferenceLimiter<L> {
    lead_m: L,
    step_m: L,
    last_m: L,
}

/// A limited reference.
#[derive(Debug, Clone, Copy)]
pub struct LimitedReference<L: Lane> {
    /// In m.
    pub reference_m: L,
    /// Lanes too far from the slave.
    pub too_far: L::Mask,
    /// Lanes beyond the speed.
    pub too_fast: L::Mask,
}

impl<L: Lane> ReferenceLimiter<L> {
    /// Starts at a reference in m.
    #[must_use]
    pub fn new(settings: &SafetySettings, tick_s: f64, start_m: L) -> Self {
        Self {
            lead_m: L::splat(settings.lead_m),
            step_m: L::splat(settings.reference_speed_m_per_s * tick_s),
            last_m: start_m,
        }
    }

    /// In m.
    #[inline(always)]
    pub fn last_m(&self) -> L {
        self.last_m
    }

    /// Limits the next reference in m.
    #[inline(always)]
    pub fn limit(&mut self, wanted_m: L, slave_m: L) -> LimitedReference<L> {
        self.limit_to(wanted_m, slave_m, self.step_m)
    }

    /// Like [`ReferenceLimiter::limit`], with a smaller step per tick in m.
    #[inline(always)]
    pub fn limit_to(&mut self, wanted_m: L, slave_m: L, step_m: L) -> LimitedReference<L> {
        let step_m = step_m.min(self.step_m);
        let near = wanted_m.clamp(slave_m - self.lead_m, slave_m + self.lead_m);
        let (low, high) = (self.last_m - step_m, self.last_m + step_m);
        let too_fast = near.lt(low) | near.gt(high);
        self.last_m = near.clamp(low, high);
        LimitedReference { reference_m: self.last_m, too_far: near.lt(wanted_m) | near.gt(wanted_m), too_fast }
    }

    /// May jump: only for the first sample.
    pub(super) fn start_at(&mut self, reference_m: L) {
        self.last_m = reference_m;
    }
}

crate::lane::gather!(ReferenceLimiter { lead_m, step_m, last_m } stored);

#[cfg(test)]
mod tests {
    use super::*;

    fn limiter() -> ReferenceLimiter<f64> {
        let settings = SafetySettings { lead_m: 0.01, reference_speed_m_per_s: 1.0, ..SafetySettings::DEFAULT };
        ReferenceLimiter::new(&settings, 1e-3, 0.0)
    }

    #[test]
    fn a_reference_within_its_limits_passes_bit_for_bit() {
        let mut limiter = limiter();
        for k in 0..500 {
            let wanted = 0.005 * libm::sin(0.1 * f64::from(k));
            let limited = limiter.limit(wanted, 0.0);
            assert_eq!(limited.reference_m.to_bits(), wanted.to_bits(), "{k}");
            assert!(!limited.too_far && !limited.too_fast, "{k}");
        }
    }

    #[test]
    fn a_jump_becomes_a_motion_that_ends_near_the_slave() {
        let mut limiter = limiter();
        let references: Vec<f64> = (0..12).map(|_| limiter.limit(0.5, 0.0).reference_m).collect();
        assert!((references[0] - 0.001).abs() < 1e-15 && (references[8] - 0.009).abs() < 1e-15, "{references:?}");
        assert_eq!(references[9..], [0.01; 3], "0.01 m from the slave");
        assert!(limiter.limit(0.5, 0.0).too_far);
    }

    #[test]
    fn the_speed_has_priority_over_the_distance() {
        let mut limiter = limiter();
        limiter.limit(0.0, 0.0);
        let limited = limiter.limit(0.0, 0.1);
        assert_eq!((limited.reference_m, limited.too_far, limited.too_fast), (0.001, true, true));
    }
}
