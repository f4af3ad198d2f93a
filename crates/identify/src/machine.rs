use trocar_base::interrupt;
use trocar_core::friction::CoulombFriction;

use crate::filter::delayed;
use crate::measured::Measured;

/// Samples are divided into equal steps of at most this length.
const LONGEST_STEP_S: f64 = 2.5e-4;

/// Per sample, for recordings at low rates.
const MAX_STEPS: usize = 64;

/// `m ẍ = u - b ẋ - F(ẋ) - f`, `u(t) = K_p e(t - δ) + K_d ė(t - δ)`, `e = x_m - x`
///
/// with the load f and Coulomb friction `F = F_c sign(ẋ)`, which holds the slave at rest while the other forces are
/// below F_c. For short delays the controller is expanded to the second derivative:
/// `u = K_p e + (K_d - K_p δ) ė + (K_p δ²/2 - K_d δ) ë`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Machine {
    /// m
    pub mass_kg: f64,
    /// b
    pub viscous_n_s_per_m: f64,
    /// F_c
    pub coulomb_n: f64,
    /// K_p
    pub position_gain_n_per_m: f64,
    /// K_d
    pub velocity_gain_n_s_per_m: f64,
    /// δ of the controller.
    pub delay_s: f64,
    pub load: Load,
}

/// `f(t) = y + (scale - 1) min(max(y, -F), F) + offset` at the reading `y = measured(t + lag) - zero`.
///
/// The slope is 1 beyond F, the largest reading from which the scale was estimated, so that its error is not
/// extrapolated to larger forces.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Load {
    /// True force per measured force.
    pub scale: f64,
    /// F.
    pub scaled_up_to_n: f64,
    /// Against the motion: an offset of the sensor, or gravity.
    pub offset_n: f64,
    /// The sensor lags behind the force.
    pub lag_s: f64,
}

impl Machine {
    /// Slave positions in m, one per sample, from the measured first position and velocity; `None` if the simulation
    /// diverges. `zero_n` is the sensor's zero.
    ///
    /// Without delay, a step of length h solves for the mean velocity w with the implicit midpoint rule:
    /// `(2 m/h + b + K_d + K_p h/2) w + F(w) = 2 m v/h + K_p (x_m - x) + K_d ẋ_m - f`. The slave rests if the right
    /// side is within ±F_c: exact stiction without chatter.
    pub fn simulate(&self, measured: &Measured, zero_n: f64) -> Option<Vec<f64>> {
        let interval_s = measured.interval_s;
        let steps = ((interval_s / LONGEST_STEP_S - 1e-9).ceil() as usize).clamp(1, MAX_STEPS);
        let step_s = interval_s / steps as f64;
        let (gain, delay_s) = (self.position_gain_n_per_m, self.delay_s);
        let damping = self.velocity_gain_n_s_per_m - gain * delay_s;
        let virtual_mass = self.velocity_gain_n_s_per_m * delay_s - 0.5 * gain * delay_s * delay_s;
        // The expansion is invalid if the mass is mostly delay.
        let mass = (self.mass_kg - virtual_mass).max(0.1 * self.mass_kg);
        let inertia = 2.0 * mass / step_s;
        let denominator = inertia + self.viscous_n_s_per_m + damping + 0.5 * gain * step_s;
        if !(denominator.is_finite() && denominator > 0.0) {
            return None;
        }
        let friction = CoulombFriction { limit_n: self.coulomb_n };
        let load_n = self.load.on(measured, zero_n);
        let mut position_m = measured.slave_m[0];
        let mut velocity = measured.start_velocity_m_per_s;
        let mut positions_m = Vec::with_capacity(measured.len());
        positions_m.push(position_m);
        for sample in 1..measured.len() {
            interrupt::check_at(sample as u64);
            for step in 0..steps {
                let share = (step as f64 + 0.5) / steps as f64;
                let between = |values: &[f64]| values[sample - 1] + share * (values[sample] - values[sample - 1]);
                let drive = gain * (between(&measured.master_m) - position_m)
                    + damping * between(&measured.master_velocity_m_per_s)
                    - virtual_mass * between(&measured.master_acceleration_m_per_s2)
                    - between(&load_n);
                let force_n = inertia * velocity + drive;
                if friction.holds(force_n) {
                    velocity = 0.0;
                    continue;
                }
                let mean_velocity = friction.remainder_n(force_n) / denominator;
                position_m += step_s * mean_velocity;
                let after = 2.0 * mean_velocity - velocity;
                // Friction can hold the slave at rest within the step.
                let rests = after * mean_velocity < 0.0 && friction.holds(drive);
                velocity = if rests { 0.0 } else { after };
            }
            positions_m.push(position_m);
        }
        positions_m.iter().all(|position_m| position_m.abs() < 1e9).then_some(positions_m)
    }
}

impl Load {
    pub const EXACT: Self = Self { scale: 1.0, scaled_up_to_n: f64::INFINITY, offset_n: 0.0, lag_s: 0.0 };

    fn on(&self, measured: &Measured, zero_n: f64) -> Vec<f64> {
        let load_n = |reading_n: f64| {
            let scaled_n = reading_n.clamp(-self.scaled_up_to_n, self.scaled_up_to_n);
            reading_n + (self.scale - 1.0) * scaled_n + self.offset_n
        };
        (0..measured.len()).map(|sample| load_n(self.reading_n(measured, sample) - zero_n)).collect()
    }

    /// A lag after a sample; held beyond the ends.
    pub(crate) fn reading_n(&self, measured: &Measured, sample: usize) -> f64 {
        delayed(&measured.force_n, sample, -self.lag_s, measured.interval_s)
    }

    /// Above the zero, in N. Requires a scale above 0.
    pub(crate) fn reading_of(&self, load_n: f64) -> f64 {
        let scaled_n = (load_n - self.offset_n) / self.scale;
        if scaled_n.abs() <= self.scaled_up_to_n {
            scaled_n
        } else {
            load_n - self.offset_n - (self.scale - 1.0) * self.scaled_up_to_n.copysign(scaled_n)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::measured::tests::measured;

    const FREE: Machine = Machine {
        mass_kg: 0.4,
        viscous_n_s_per_m: 0.0,
        coulomb_n: 0.3,
        position_gain_n_per_m: 0.0,
        velocity_gain_n_s_per_m: 0.0,
        delay_s: 0.0,
        load: Load::EXACT,
    };

    #[test]
    fn coulomb_friction_stops_a_free_mass_after_its_closed_form() {
        // v(t) = v_0 - F_c t / m: the mass stops at t = m v_0 / F_c after m v_0² / (2 F_c).
        let velocity = 0.2;
        let mut free = measured(0.001, 1000, |_| (0.0, 0.0, 0.0));
        free.start_velocity_m_per_s = velocity;
        let positions = FREE.simulate(&free, 0.0).expect("finite");
        let distance = FREE.mass_kg * velocity * velocity / (2.0 * FREE.coulomb_n);
        let stop_s = FREE.mass_kg * velocity / FREE.coulomb_n;
        let end = positions[999];
        assert!((end - distance).abs() < 1e-4 * distance, "{end} against {distance}");
        let stopped = positions.iter().position(|x| *x == end).expect("the end itself") as f64 * 1e-3;
        assert!((stopped - stop_s).abs() < 2e-3, "{stopped} against {stop_s}");
    }

    #[test]
    fn friction_holds_a_loaded_mass_at_rest_up_to_its_limit() {
        // The sensor reads 0.1 N without a load.
        let loaded = |load_n: f64| {
            let one = measured(0.001, 500, |_| (0.0, 0.0, load_n + 0.1));
            FREE.simulate(&one, 0.1).expect("finite")
        };
        assert!(loaded(0.2999).iter().all(|x| *x == 0.0));
        // Beyond the limit: x(t) = -(f - F_c) t² / (2 m).
        let end = loaded(0.5)[499];
        let expected = -0.2 * 0.499_f64.powi(2) / (2.0 * 0.4);
        assert!((end - expected).abs() < 1e-3 * expected.abs(), "{end} against {expected}");
    }

    #[test]
    fn a_damped_oscillator_follows_its_closed_form() {
        // A step of the master by 1: x = 1 - e^{-ζωt} (cos ω_d t + ζω/ω_d sin ω_d t), without a jump of ẋ_m.
        let machine = Machine { viscous_n_s_per_m: 4.0, coulomb_n: 0.0, position_gain_n_per_m: 400.0, ..FREE };
        let step = measured(0.001, 600, |_| (1.0, 0.0, 0.0));
        let positions = machine.simulate(&step, 0.0).expect("finite");
        let (decay, omega) = (4.0 / 0.8, (400.0_f64 / 0.4 - 25.0).sqrt());
        for (k, x) in positions.iter().enumerate() {
            let t = k as f64 * 1e-3;
            let expected = 1.0 - (-decay * t).exp() * ((omega * t).cos() + decay / omega * (omega * t).sin());
            assert!((x - expected).abs() < 3e-5, "{k}: {x} against {expected}");
        }
    }

    #[test]
    fn a_lag_and_a_scale_act_on_the_load() {
        let ramp = measured(0.001, 100, |t_s| (0.0, 0.0, 10.0 * t_s));
        let load = Load { scale: 2.0, scaled_up_to_n: 0.4, offset_n: 1.0, lag_s: 0.0005 };
        let load_n = load.on(&ramp, 0.05);
        assert!((load_n[10] - (2.0 * (10.0 * 0.0105 - 0.05) + 1.0)).abs() < 1e-12, "{}", load_n[10]);
        // Beyond 0.4 N above the zero, the slope is 1.
        assert!((load_n[99] - (0.99 - 0.05 + 0.4 + 1.0)).abs() < 1e-12, "{}", load_n[99]);
        for sample in [10, 99] {
            let reading_n = load.reading_n(&ramp, sample) - 0.05;
            assert!((load.reading_of(load_n[sample]) - reading_n).abs() < 1e-12, "{sample}");
        }
    }

    #[test]
    fn a_machine_that_diverges_has_no_positions() {
        let machine = Machine { viscous_n_s_per_m: -1e3, ..FREE };
        assert_eq!(machine.simulate(&measured(0.001, 500, |_| (1.0, 0.0, -1.0)), 0.0), None);
    }
}
