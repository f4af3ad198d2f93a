use super::{FaultCause, SafetySettings};
use crate::lane::Stored;

/// Above the offset of an untared sensor (chosen here).
const PULL_N: f64 = 1.0;

/// Accepted ratio of the velocity's integral to the motion.
const RATIO: (f64, f64) = (0.5, 2.0);

/// The comparison then restarts, because noise accumulates.
const COMPARED_SAMPLES: u32 = 10_000;

/// A sample of the slave.
#[derive(Debug, Clone, Copy)]
pub struct SlaveSample {
    /// Increasing into the tissue.
    pub position_m: f64,
    /// `None` if it is estimated from the positions.
    pub velocity_m_per_s: Option<f64>,
    /// Positive when the tissue resists.
    pub force_n: f64,
}

#[derive(Debug, Clone)]
pub(super) struct Plausibility {
    stuck_travel_m: f64,
    pull_travel_m: f64,
    velocity_travel_m: f64,
    tick_s: f64,
    last_m: f64,
    last_n: f64,
    has_last: bool,
    /// Travel since the force changed, and into the tissue against a pulling force.
    constant_m: f64,
    pulled_m: f64,
    moved_m: f64,
    integrated_m: f64,
    compared: u32,
}

impl Plausibility {
    pub(super) fn new(settings: &SafetySettings, tick_s: f64) -> Self {
        Self {
            stuck_travel_m: settings.stuck_travel_m,
            pull_travel_m: settings.pull_travel_m,
            velocity_travel_m: settings.velocity_travel_m,
            tick_s,
            last_m: 0.0,
            last_n: 0.0,
            has_last: false,
            constant_m: 0.0,
            pulled_m: 0.0,
            moved_m: 0.0,
            integrated_m: 0.0,
            compared: 0,
        }
    }

    pub(super) fn restart(&mut self) {
        self.has_last = false;
        (self.constant_m, self.pulled_m) = (0.0, 0.0);
        (self.moved_m, self.integrated_m, self.compared) = (0.0, 0.0, 0);
    }

    #[inline(always)]
    pub(super) fn check(&mut self, sample: &SlaveSample) -> Option<FaultCause> {
        let SlaveSample { position_m, velocity_m_per_s, force_n } = *sample;
        if !self.has_last {
            self.has_last = true;
            (self.last_m, self.last_n) = (position_m, force_n);
            return None;
        }
        let step_m = position_m - self.last_m;
        // In free air without noise the force is 0.
        let is_constant = (force_n == self.last_n) & (force_n != 0.0);
        (self.last_m, self.last_n) = (position_m, force_n);
        self.constant_m = if is_constant { self.constant_m + step_m.abs() } else { 0.0 };
        let advanced_m = step_m.max(0.0);
        self.pulled_m =
            if force_n < -PULL_N { self.pulled_m + advanced_m } else { (self.pulled_m - advanced_m).max(0.0) };
        let mut cause = None;
        if let Some(velocity_m_per_s) = velocity_m_per_s {
            self.moved_m += step_m;
            self.integrated_m += velocity_m_per_s * self.tick_s;
            self.compared += 1;
            if self.moved_m.abs().max(self.integrated_m.abs()) >= self.velocity_travel_m {
                let ratio = self.integrated_m / self.moved_m;
                if !(RATIO.0..=RATIO.1).contains(&ratio) {
                    cause = Some(FaultCause::Velocity);
                }
                (self.moved_m, self.integrated_m, self.compared) = (0.0, 0.0, 0);
            } else if self.compared >= COMPARED_SAMPLES {
                (self.moved_m, self.integrated_m, self.compared) = (0.0, 0.0, 0);
            }
        }
        if self.constant_m >= self.stuck_travel_m {
            cause = Some(FaultCause::StuckForce);
        } else if self.pulled_m >= self.pull_travel_m {
            cause = Some(FaultCause::ForceSign);
        }
        cause
    }
}

impl Stored for Plausibility {
    fn numbers(&mut self, with: &mut dyn FnMut(&mut u64)) {
        let Self {
            stuck_travel_m: _,
            pull_travel_m: _,
            velocity_travel_m: _,
            tick_s: _,
            last_m,
            last_n,
            has_last,
            constant_m,
            pulled_m,
            moved_m,
            integrated_m,
            compared,
        } = self;
        for number in [last_m, last_n, constant_m, pulled_m, moved_m, integrated_m] {
            number.numbers(with);
        }
        has_last.numbers(with);
        compared.numbers(with);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The first cause on 2000 samples of an insertion at 10 mm/s into 300 N/m, and its sample.
    fn cause(change: impl Fn(u32, SlaveSample) -> SlaveSample) -> Option<(u32, FaultCause)> {
        let mut checks = Plausibility::new(&SafetySettings::DEFAULT, 1e-3);
        (0..2000).find_map(|k| {
            let depth = 1e-5 * f64::from(k);
            let sample = SlaveSample { position_m: depth, velocity_m_per_s: Some(0.01), force_n: 300.0 * depth };
            checks.check(&change(k, sample)).map(|cause| (k, cause))
        })
    }

    #[test]
    fn a_plausible_insertion_has_no_fault() {
        assert_eq!(cause(|_, sample| sample), None);
        assert_eq!(cause(|_, sample| SlaveSample { force_n: 0.0, ..sample }), None, "free air");
        assert_eq!(cause(|_, sample| SlaveSample { velocity_m_per_s: None, ..sample }), None);
    }

    #[test]
    fn a_force_that_stays_constant_during_a_motion_is_stuck() {
        // 2 mm at 10 mm/s.
        let stuck = cause(|k, sample| if k < 500 { sample } else { SlaveSample { force_n: 1.5, ..sample } });
        assert!(matches!(stuck, Some((699..=702, FaultCause::StuckForce))), "{stuck:?}");
    }

    #[test]
    fn a_force_that_pulls_the_needle_into_the_tissue_has_the_wrong_sign() {
        // 1 N is reached at 3.3 mm.
        let reversed = cause(|_, sample| SlaveSample { force_n: -sample.force_n, ..sample });
        assert!(matches!(reversed, Some((830..=840, FaultCause::ForceSign))), "{reversed:?}");
    }

    #[test]
    fn a_velocity_in_another_unit_or_with_another_sign_is_found() {
        for factor in [1000.0, 1e-3, -1.0, 0.0] {
            let scaled = cause(|_, sample| {
                let velocity_m_per_s = sample.velocity_m_per_s.map(|velocity| factor * velocity);
                SlaveSample { velocity_m_per_s, ..sample }
            });
            assert!(matches!(scaled, Some((1..=502, FaultCause::Velocity))), "{factor}: {scaled:?}");
        }
    }

    #[test]
    fn a_gap_starts_the_checks_anew() {
        let mut checks = Plausibility::new(&SafetySettings::DEFAULT, 1e-3);
        let sample = |position_m| SlaveSample { position_m, velocity_m_per_s: Some(0.0), force_n: 1.0 };
        assert_eq!(checks.check(&sample(0.0)), None);
        checks.restart();
        assert_eq!(checks.check(&sample(0.1)), None, "the motion in the gap does not count");
    }
}
