//! Coulomb friction.

/// `F(v) = F_c sign(v)`, which at rest balances every force of at most `F_c`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CoulombFriction {
    /// `F_c` in N, at least 0.
    pub limit_n: f64,
}

impl CoulombFriction {
    /// True if friction balances a force on a body at rest.
    #[must_use]
    pub fn holds(self, force_n: f64) -> bool {
        force_n.abs() <= self.limit_n
    }

    /// `f - F_c sign(f)`, or 0 if friction holds.
    #[must_use]
    pub fn remainder_n(self, force_n: f64) -> f64 {
        if self.holds(force_n) { 0.0 } else { force_n - self.limit_n.copysign(force_n) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn friction_holds_up_to_its_limit_and_reduces_a_larger_force() {
        let friction = CoulombFriction { limit_n: 0.3 };
        assert!(friction.holds(0.3) && friction.holds(-0.3) && !friction.holds(0.300_001));
        assert_eq!([0.2, 0.5, -1.3].map(|force_n| friction.remainder_n(force_n)), [0.0, 0.5 - 0.3, -1.3 + 0.3]);
        assert_eq!(CoulombFriction { limit_n: 0.0 }.remainder_n(-2.0), -2.0);
        assert!(friction.remainder_n(f64::NAN).is_nan());
    }
}
