//! A reference whose steps are limited by the available energy.

use crate::lane::Lane;

/// Follows a target. A step against a force costs work; it is shortened to the available energy.
///
/// The deficit is recovered later, in addition to the target's motion, by at most `step` per tick.
#[derive(Debug, Clone)]
pub(super) struct Meter<L> {
    step: L,
    target: L,
    reference: L,
    /// `∫ f d(target - reference)` in J: the work withheld from the slave, less what was recovered.
    pub(super) refused_j: L,
}

impl<L: Lane> Meter<L> {
    pub(super) fn new(speed_m_per_s: f64, tick_s: f64, start: L) -> Self {
        Self { step: L::splat(speed_m_per_s * tick_s), target: start, reference: start, refused_j: L::zero() }
    }

    /// The reference, at a cost of `force` (J/m) and with `energy` (J) available.
    #[inline(always)]
    pub(super) fn follow(&mut self, target: L, force: L, energy: L) -> L {
        let zero = L::zero();
        let deficit = (self.target - self.reference).clamp(-self.step, self.step);
        let step = (target - self.target) + deficit;
        let cost = force * step;
        let affordable = energy.max(zero);
        let is_cut = cost.gt(affordable);
        let allowed = L::select(is_cut, step * (affordable / L::select(is_cut, cost, L::splat(1.0))), step);
        // An unlimited step follows the target bit for bit.
        let reference =
            L::select(is_cut, self.reference + allowed, target - ((self.target - self.reference) - deficit));
        let refused = (target - self.target) - (reference - self.reference);
        self.refused_j = self.refused_j + force * refused;
        (self.target, self.reference) = (target, reference);
        reference
    }
}

crate::lane::gather!(Meter { step, target, reference, refused_j });

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_stops_without_energy_and_catches_up_at_its_speed() {
        let mut meter = Meter::<f64>::new(0.03, 1e-3, 0.0);
        assert_eq!(meter.follow(1e-5, 2.0, 1.0), 1e-5);
        assert_eq!(meter.follow(2e-5, 2.0, 0.0), 1e-5);
        assert_eq!(meter.follow(2e-4, 2.0, -1.0), 1e-5);
        // A target that turns back reduces the deficit.
        assert!((meter.follow(1.9e-4, 2.0, 0.0) - 1e-5).abs() < 1e-18);
        let next = meter.follow(1.9e-4, 2.0, 1.0);
        assert!((next - 4e-5).abs() < 1e-18, "{next}");
        assert!(meter.refused_j > 0.0);
    }

    #[test]
    fn half_the_energy_is_half_the_way() {
        let mut meter = Meter::<f64>::new(0.03, 1e-3, 0.0);
        assert!((meter.follow(1e-4, 5.0, 2.5e-4) - 5e-5).abs() < 1e-18);
    }
}
