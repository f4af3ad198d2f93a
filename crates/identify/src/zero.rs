//! The reading of the force sensor without a load, which drifts from recording to recording. Only the inputs of a
//! recording determine it, so predicted recordings can be corrected too.

use trocar_base::quantiles;

use crate::machine::Machine;
use crate::measured::{Measured, span};

/// Maximum range of the forces in free motion, relative to the largest one.
const FREE_SHARE: f64 = 1.0 / 3.0;

/// Maximum rise of the lowest forces with the master's motion, without contact.
const FLAT_SHARE: f64 = 1.0 / 3.0;

/// In units of the Coulomb friction; a preload is farther.
const LARGEST_DRIFT: f64 = 2.0;

/// Below it the slave may rest with any friction up to the limit.
const AT_REST_M_PER_S: f64 = 2e-3;

#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct FreeMotion {
    pub(crate) recording: usize,
    pub(crate) zero_n: f64,
    /// The range that contains 98 % of the forces.
    pub(crate) width_n: f64,
}

impl FreeMotion {
    /// `None` unless one recording has much smaller forces than the others.
    pub(crate) fn of(training: &[Measured]) -> Option<Self> {
        let spans: Vec<f64> = training.iter().map(|one| span(&one.force_n)).collect();
        let (recording, smallest) = spans.iter().enumerate().min_by(|a, b| a.1.total_cmp(b.1))?;
        let largest = spans.iter().copied().fold(0.0, f64::max);
        (*smallest < FREE_SHARE * largest).then(|| {
            let sorted = sorted(&training[recording].force_n);
            let zero_n = sorted.iter().sum::<f64>() / sorted.len() as f64;
            Self { recording, zero_n, width_n: quantile(&sorted, 0.99) - quantile(&sorted, 0.01) }
        })
    }

    /// Median of the lowest forces. `None` if these rise with the motion (permanent contact) or are far from those in
    /// free motion (preload).
    pub(crate) fn tare(&self, measured: &Measured, coulomb_n: f64) -> Option<f64> {
        let highest_n = quantile(&sorted(&measured.force_n), 0.005) + self.width_n;
        let lowest = measured.force_n.iter().zip(&measured.master_m).filter(|(force_n, _)| **force_n <= highest_n);
        let (forces_n, masters_m): (Vec<f64>, Vec<f64>) = lowest.unzip();
        let zero_n = quantile(&sorted(&forces_n), 0.5);
        let rise = span(&measured.force_n) / span(&measured.master_m);
        let is_flat = self.width_n < FLAT_SHARE * rise * span(&masters_m);
        let is_near = (zero_n - self.zero_n).abs() < LARGEST_DRIFT * coulomb_n;
        (is_flat && is_near).then_some(zero_n)
    }

    /// Without a part free of contact, averages the mean training zero and the zero that balances the first sample.
    pub(crate) fn predicted(&self, measured: &Measured, machine: &Machine, trained_n: &[f64]) -> f64 {
        self.tare(measured, machine.coulomb_n).unwrap_or_else(|| {
            let mean_n = trained_n.iter().sum::<f64>() / trained_n.len() as f64;
            0.5 * (mean_n + balanced(measured, machine, mean_n))
        })
    }
}

/// The zero at which the load at the first sample balances the other forces. Friction at rest allows an interval; the
/// zero nearest to `expected_n` is returned.
fn balanced(measured: &Measured, machine: &Machine, expected_n: f64) -> f64 {
    let velocity = measured.start_velocity_m_per_s;
    let acceleration = measured.master_acceleration_m_per_s2[0];
    let error_m = measured.master_m[0] - measured.slave_m[0];
    let error_rate = measured.master_velocity_m_per_s[0] - velocity;
    let damping = machine.velocity_gain_n_s_per_m - machine.position_gain_n_per_m * machine.delay_s;
    let drive_n = machine.position_gain_n_per_m * error_m + damping * error_rate
        - machine.mass_kg * acceleration
        - machine.viscous_n_s_per_m * velocity;
    let reading_n = machine.load.reading_n(measured, 0);
    let zero_n = |friction_n: f64| reading_n - machine.load.reading_of(drive_n - friction_n);
    if velocity.abs() > AT_REST_M_PER_S {
        return zero_n(machine.coulomb_n.copysign(velocity));
    }
    let ends = [zero_n(-machine.coulomb_n), zero_n(machine.coulomb_n)];
    expected_n.clamp(ends[0].min(ends[1]), ends[0].max(ends[1]))
}

fn sorted(values: &[f64]) -> Vec<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted
}

/// Linear between values; requires at least one.
fn quantile(sorted: &[f64], share: f64) -> f64 {
    quantiles::quantile(sorted.len() as u64, share, |rank| sorted[rank as usize]).unwrap_or(f64::NAN)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::machine::Load;
    use crate::measured::tests::measured;

    const MACHINE: Machine = Machine {
        mass_kg: 0.3,
        viscous_n_s_per_m: 2.0,
        coulomb_n: 0.4,
        position_gain_n_per_m: 4000.0,
        velocity_gain_n_s_per_m: 20.0,
        delay_s: 0.0,
        load: Load { scale: 0.8, offset_n: -0.1, lag_s: 0.0, scaled_up_to_n: 2.0 },
    };

    /// The master moves by 20 mm at 0.5 Hz.
    fn place_m(t_s: f64) -> f64 {
        0.01 * (std::f64::consts::PI * t_s).sin()
    }

    /// A contact of 500 N/m beyond `contact_m`, read with a zero.
    fn contact(contact_m: f64, zero_n: f64) -> Measured {
        let force_n = |t_s| 500.0 * (place_m(t_s) - contact_m).max(0.0) + zero_n;
        measured(0.001, 4000, |t_s| (place_m(t_s), place_m(t_s), force_n(t_s)))
    }

    fn free() -> FreeMotion {
        let ripple = measured(0.001, 4000, |t_s| {
            (place_m(t_s), place_m(t_s), 0.3 + 0.1 * (10.0 * std::f64::consts::PI * t_s).sin())
        });
        FreeMotion::of(&[contact(0.0, 0.0), ripple]).expect("a recording in free motion")
    }

    #[test]
    fn the_recording_with_small_forces_is_in_free_motion() {
        let free = free();
        assert_eq!(free.recording, 1);
        assert!((free.zero_n - 0.3).abs() < 1e-3 && (free.width_n - 0.2).abs() < 1e-3, "{free:?}");
        assert_eq!(FreeMotion::of(&[contact(0.0, 0.0), contact(0.001, 0.0)]), None);
    }

    #[test]
    fn the_zero_before_contact_is_found_and_a_preload_is_none() {
        let zero_n = free().tare(&contact(0.0, 0.15), MACHINE.coulomb_n).expect("half of it is free");
        assert!((zero_n - 0.15).abs() < 1e-9, "{zero_n}");
        // Never out of contact: the lowest force rises with the motion.
        assert_eq!(free().tare(&contact(-0.011, 0.0), MACHINE.coulomb_n), None);
        // Out of contact, but 2 N from the zero of free motion.
        assert_eq!(free().tare(&contact(0.0, 2.3), MACHINE.coulomb_n), None);
    }

    #[test]
    fn the_balance_at_the_first_sample_gives_the_zero() {
        // At rest, 1 mm behind the master: the controller pushes with 4 N against the load and up to 0.4 N of friction.
        let mut one = measured(0.001, 400, |_| (0.001, 0.0, 5.0));
        // A load of 4 N is a reading of 2 + (4 + 0.1 - 1.6) = 4.5 N above the zero.
        assert!((balanced(&one, &MACHINE, 0.5) - 0.5).abs() < 1e-12);
        assert!((balanced(&one, &MACHINE, 3.0) - 0.9).abs() < 1e-12);
        assert!((balanced(&one, &MACHINE, -3.0) - 0.1).abs() < 1e-12);
        // In motion: 4 N - 20 · 0.1 N (damping) - 2 · 0.1 N (viscous) - 0.4 N = 1.4 N, a reading of 1.5 / 0.8 N.
        one.start_velocity_m_per_s = 0.1;
        assert!((balanced(&one, &MACHINE, 0.0) - (5.0 - 1.5 / 0.8)).abs() < 1e-12);
    }
}
