//! The baseline: the same experiment, written by hand for this scenario only.
//!
//! A plain loop over `f64`: the recorded force replayed over time, both plants as constant matrices, recursive least
//! squares with dead zone, normalisation and resetting, CUSUM with arming and cap, the automaton, and the decaying
//! force. The scenario's numbers are read once; the code fixes the kinds of parts. It computes no metrics.

use trocar::augmentation::{DecaySettings, ForceLawSettings, Freeze, RampSettings, Reengage};
use trocar::detector::{DistanceKind, Motion};
use trocar::plant::{MASTER_STATES, MasterStep, SLAVE_STATES, SlaveStep};
use trocar::scenario::Scenario;
use trocar::time::nearest_ticks;

pub struct Handwritten {
    desired_m: Vec<f64>,
    force_n: Vec<f64>,
    /// Columns: the states, `x_d` now and at the next tick, `F_ed`.
    master: [[f64; MASTER_STATES]; MASTER_STATES + 3],
    /// Columns: the states, `x_ref`.
    slave: [[f64; SLAVE_STATES]; SLAVE_STATES + 1],
    slave_rest: [f64; SLAVE_STATES],
    position_scale: f64,
    force_scale: f64,
    contact_m: f64,
    gain: f64,
    reset_threshold: f64,
    dead_zone_n: f64,
    inverse_dead_zone: f64,
    normalisation: f64,
    threshold: f64,
    drift: f64,
    cap: f64,
    settle_ticks: usize,
    slowest_m_per_s: f64,
    exit_level: f64,
    hold_ticks: (usize, usize),
    exit_quiet_ticks: usize,
    refractory_ticks: usize,
    blend_ticks: usize,
    closing_step_m: f64,
    decay_ratio: f64,
    decay: f64,
}

enum Mode {
    Teleoperation,
    Augmented,
    Reengaging,
}

impl Handwritten {
    /// Takes the parameters of a scenario, its desired positions (m, one more than ticks) and its forces (N).
    ///
    /// # Panics
    /// Panics if the scenario has other kinds of parts.
    pub fn new(scenario: &Scenario, desired_m: Vec<f64>, force_n: Vec<f64>) -> Self {
        let tick_s = scenario.grid.tick_s();
        let (cusum, arming) = (&scenario.detector.cusum, &scenario.detector.arming);
        let (augmentation, automaton) = (&scenario.augmentation, &scenario.augmentation.automaton);
        let ForceLawSettings::Decay(DecaySettings { ratio, time_constant_s }) = augmentation.force else {
            panic!("another force law")
        };
        let Reengage::Ramp(RampSettings { catch_up_speed_m_per_s }) = augmentation.reengage else {
            panic!("another re-engaging policy")
        };
        assert!(augmentation.enabled && augmentation.freeze == Freeze::Measured, "another freeze");
        assert_eq!(scenario.detector.distance.kind, DistanceKind::SquaredResidual);
        assert!(arming.drop_only && arming.motion == Motion::NotWithdrawn && arming.minimum_depth_m == 0.0);
        let master = MasterStep::new(&scenario.master, &scenario.arm, scenario.timing, tick_s).expect("valid");
        let slave = SlaveStep::new(&scenario.slave, scenario.timing, tick_s).expect("valid");
        let ticks = |duration_s| nearest_ticks(duration_s, tick_s) as usize;
        Self {
            desired_m,
            force_n,
            master: std::array::from_fn(|j| match j {
                5 => master.desired_now,
                6 => master.desired_next,
                7 => master.feedback,
                _ => master.transition.map(|row| row[j]),
            }),
            slave: std::array::from_fn(|j| match j {
                3 => slave.reference,
                _ => slave.transition.map(|row| row[j]),
            }),
            slave_rest: slave.rest,
            position_scale: scenario.link.machines.position_scale,
            force_scale: scenario.link.machines.force_scale,
            contact_m: scenario.contact_m,
            gain: scenario.estimator.initial_gain,
            reset_threshold: scenario.estimator.reset_threshold,
            dead_zone_n: scenario.estimator.dead_zone_n,
            inverse_dead_zone: 1.0 / scenario.estimator.dead_zone_n,
            normalisation: scenario.estimator.normalisation,
            threshold: cusum.threshold,
            drift: cusum.drift,
            cap: cusum.cap,
            settle_ticks: ticks(arming.settle_s),
            slowest_m_per_s: -arming.withdrawal_speed_m_per_s,
            exit_level: automaton.exit_ratio * cusum.threshold,
            hold_ticks: (ticks(automaton.min_hold_s), ticks(automaton.max_hold_s)),
            exit_quiet_ticks: ticks(automaton.exit_quiet_s),
            refractory_ticks: ticks(automaton.refractory_s),
            blend_ticks: ticks(augmentation.blend_s).max(1),
            closing_step_m: catch_up_speed_m_per_s * tick_s,
            decay_ratio: ratio,
            decay: (-tick_s / time_constant_s).exp(),
        }
    }

    pub fn ticks(&self) -> usize {
        self.force_n.len()
    }

    /// Runs the experiment and writes the slave's position at each tick (m). Returns the number of alarms.
    pub fn run(&self, slave_m: &mut [f64]) -> u64 {
        self.run_here(slave_m)
    }

    /// [`Handwritten::run`], compiled for AVX2.
    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2")]
    pub fn run_avx2(&self, slave_m: &mut [f64]) -> u64 {
        self.run_here(slave_m)
    }

    #[inline(always)]
    fn run_here(&self, slave_m: &mut [f64]) -> u64 {
        let start_m = self.desired_m[0];
        let mut master = [start_m, 0.0, start_m, 0.0, 0.0];
        let reference_m = self.position_scale * start_m;
        let [on_x_e, on_v_e, on_third] = self.slave_rest;
        let mut slave = [on_x_e * reference_m, on_v_e * reference_m, on_third * reference_m];
        let (mut stiffness, mut damping) = (0.0, 0.0);
        let (mut f00, mut f01, mut f11) = (self.gain, 0.0, self.gain);
        let mut information = 2.0 / self.gain;
        let (mut p, mut v, mut expected) = (0.0, 0.0, 0.0);
        let (mut g, mut quiet) = (0.0_f64, 0_usize);
        let mut mode = Mode::Teleoperation;
        let (mut entered, mut refractory_until, mut quiet_ticks, mut alarms) = (0, 0, 0, 0);
        let (mut gap, mut frozen) = (0.0_f64, 0.0);
        let (mut feedback_n, mut anchor, mut last_force) = (0.0, 0.0, 0.0);

        assert!(slave_m.len() == self.ticks() && self.desired_m.len() > self.ticks());
        for (k, slave_m) in slave_m.iter_mut().enumerate() {
            let y = self.force_n[k];
            let (x_e, v_e) = (slave[0], slave[1]);
            *slave_m = x_e;
            let depth = x_e - self.contact_m;

            let predicted = expected;
            let e = y - predicted;
            if e.abs() > self.dead_zone_n {
                let delta = (e.abs() * self.inverse_dead_zone - 1.0).min(1.0);
                let square = p * p + v * v;
                let inverse_weight = 1.0 + self.normalisation * square;
                let (q0, q1) = (f00 * p + f01 * v, f01 * p + f11 * v);
                let share = delta / (inverse_weight + (p * q0 + v * q1));
                stiffness += share * (q0 * e);
                damping += share * (q1 * e);
                f00 -= share * (q0 * q0);
                f01 -= share * (q0 * q1);
                f11 -= share * (q1 * q1);
                information += delta * square / inverse_weight;
                if information >= self.reset_threshold {
                    (f00, f01, f11, information) = (self.gain, 0.0, self.gain, 2.0 / self.gain);
                }
            }
            let contact = depth > 0.0;
            (p, v) = if contact { (depth, v_e) } else { (0.0, 0.0) };
            expected = p * stiffness + v * damping;

            g = (g + (e * e - self.drift)).max(0.0).min(self.cap);
            let decision = g;
            let settled = quiet >= self.settle_ticks;
            quiet = if contact { quiet + 1 } else { 0 };
            let mut alarm = false;
            if g > self.threshold {
                quiet = 0;
                alarm = settled && contact && v_e >= self.slowest_m_per_s && e < 0.0 && predicted > 0.0;
                if alarm {
                    g = 0.0;
                }
            }

            let hand = self.position_scale * master[0];
            let force = self.force_scale * y;
            match mode {
                Mode::Teleoperation => {
                    if alarm && k >= refractory_until {
                        (mode, entered, quiet_ticks, frozen) = (Mode::Augmented, k, 0, x_e);
                        (feedback_n, anchor) = (last_force, last_force);
                        alarms += 1;
                    }
                }
                Mode::Augmented => {
                    quiet_ticks = if decision < self.exit_level { quiet_ticks + 1 } else { 0 };
                    let held = k - entered;
                    let is_over = held >= self.hold_ticks.0 && quiet_ticks >= self.exit_quiet_ticks;
                    if is_over || held >= self.hold_ticks.1 {
                        (mode, entered, gap) = (Mode::Reengaging, k, frozen - hand);
                    }
                }
                Mode::Reengaging => {
                    if gap == 0.0 && k - entered >= self.blend_ticks {
                        (mode, refractory_until) = (Mode::Teleoperation, k + self.refractory_ticks);
                    } else {
                        gap -= gap.clamp(-self.closing_step_m, self.closing_step_m);
                    }
                }
            }
            let (reference, feedback) = match mode {
                Mode::Teleoperation => (hand + gap, force),
                Mode::Augmented => {
                    let end = self.decay_ratio * anchor;
                    feedback_n = end + (feedback_n - end) * self.decay;
                    (frozen, feedback_n)
                }
                Mode::Reengaging => {
                    let u = ((k - entered + 1) as f64 / self.blend_ticks as f64).min(1.0);
                    (hand + gap, feedback_n + u * u * (3.0 - 2.0 * u) * (force - feedback_n))
                }
            };
            last_force = force;

            let (now, next) = (self.desired_m[k], self.desired_m[k + 1]);
            master =
                advance(&self.master, [master[0], master[1], master[2], master[3], master[4], now, next, feedback]);
            slave = advance(&self.slave, [x_e, v_e, slave[2], reference]);
        }
        alarms
    }
}

/// Computes `Σ_j columns[j] · inputs[j]`, with separate sums for even and odd `j` to shorten the chains of dependent
/// additions.
#[inline(always)]
fn advance<const ROWS: usize, const COLUMNS: usize>(
    columns: &[[f64; ROWS]; COLUMNS],
    inputs: [f64; COLUMNS],
) -> [f64; ROWS] {
    let (mut even, mut odd) = ([0.0; ROWS], [0.0; ROWS]);
    for j in (0..COLUMNS).step_by(2) {
        for i in 0..ROWS {
            even[i] += columns[j][i] * inputs[j];
            odd[i] += columns[j + 1][i] * inputs[j + 1];
        }
    }
    for i in 0..ROWS {
        even[i] += odd[i];
    }
    even
}
