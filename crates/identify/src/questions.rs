use crate::machine::Machine;
use crate::measured::{Measured, deviation, span};
use crate::model::Model;

/// Minimum effect of the load on the slave, relative to the simulation's error, for a contact.
const LEAST_EFFECT: f64 = 1.5;

/// Minimum motion of a reversal, relative to the range.
const REVERSAL_SHARE: f64 = 0.05;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Questions {
    pub(crate) has_contact: bool,
    pub(crate) reverses: bool,
    pub(crate) has_actuator: bool,
}

impl Questions {
    pub(crate) fn of(recordings: &[Measured], model: &Model, has_actuator: bool) -> Self {
        Self {
            has_contact: recordings
                .iter()
                .zip(&model.zeros_n)
                .any(|(one, zero_n)| load_is_visible(one, &model.machine, *zero_n)),
            reverses: recordings.iter().any(|one| reversals(&one.slave_m) > 0),
            has_actuator,
        }
    }

    /// No force has a known size.
    pub(crate) fn only_ratios(self) -> bool {
        !self.has_contact && !self.has_actuator
    }

    pub(crate) fn open(self) -> Vec<String> {
        let mut open = vec![];
        if self.only_ratios() {
            open.push(
                "Without contact and without the actuator's force, motion determines ratios only: all values are per kg of \
                 moving mass. Record a contact with a force sensor, or give --actuator.",
            );
        } else if !self.has_contact {
            open.push(
                "The recordings have no visible contact, so that scale, offset and lag of the force sensor are unknown; the sensor is \
                 taken as exact. Add a recording in contact.",
            );
        } else if !self.has_actuator {
            open.push(
                "Without the actuator's force, all absolute values rest on the calibration of the force sensor, which is taken as \
                 right within 10 %; the ratios of mass, friction and gains are more exact. Give --actuator if it is recorded.",
            );
        }
        if !self.has_actuator {
            open.push(
                "Without the actuator's force, a delay of the controller cannot be distinguished from less damping: the \
                 velocity gain is the effective one, K_d - K_p δ.",
            );
        }
        if !self.reverses {
            open.push(
                "The slave never reverses, so that Coulomb friction cannot be distinguished from a constant force. Record a \
                 motion with reversals.",
            );
        }
        if self.has_contact {
            open.push("An offset of the force sensor cannot be distinguished from gravity or another constant force.");
        }
        open.into_iter().map(str::to_owned).collect()
    }
}

/// Compares simulations with the measured load and with its mean.
fn load_is_visible(measured: &Measured, machine: &Machine, zero_n: f64) -> bool {
    let mean_n = measured.force_n.iter().sum::<f64>() / measured.len() as f64;
    let constant = Measured { force_n: vec![mean_n; measured.len()], ..measured.clone() };
    let simulate = |one| machine.simulate(one, zero_n);
    let (Some(with), Some(without)) = (simulate(measured), simulate(&constant)) else { return false };
    let differences =
        |others: &[f64]| -> Vec<f64> { with.iter().zip(others).map(|(with, other)| with - other).collect() };
    deviation(&differences(&without)) > LEAST_EFFECT * deviation(&differences(&measured.slave_m))
}

/// Ignores motions below 5 % of the range.
pub(crate) fn reversals(positions_m: &[f64]) -> usize {
    let least = REVERSAL_SHARE * span(positions_m);
    let (mut turning, mut direction, mut count) = (positions_m[0], 0.0, 0);
    for position in positions_m {
        let moved = position - turning;
        if moved * direction > 0.0 || (direction == 0.0 && moved.abs() > least) {
            direction = moved.signum();
            turning = *position;
        } else if moved.abs() > least {
            count += 1;
            direction = moved.signum();
            turning = *position;
        }
    }
    count
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reversals_are_counted_without_those_of_noise() {
        let waves: Vec<f64> = (0..1000).map(|k| (f64::from(k) * 0.02).sin() + 1e-3 * f64::from(k % 2)).collect();
        // 20 rad: the turning points at π/2, 3π/2, … below 20.
        assert_eq!(reversals(&waves), 6);
        let ramp: Vec<f64> = (0..1000).map(|k| f64::from(k) + 0.5 * f64::from(k % 2)).collect();
        assert_eq!(reversals(&ramp), 0);
    }

    #[test]
    fn motion_alone_determines_ratios_only() {
        let open = Questions { has_contact: false, reverses: false, has_actuator: false };
        assert!(open.only_ratios());
        assert!(open.open().iter().any(|text| text.contains("ratios only")));
        assert!(open.open().iter().any(|text| text.contains("never reverses")));
        assert!(!Questions { has_actuator: true, ..open }.only_ratios());
    }
}
