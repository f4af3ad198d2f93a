//! Estimator, detector and supervisor for a real controller: one `step(sample) -> command` per tick.
//!
//! The simulator runs the same source in the same order (steps 3 to 6 of the tick of `trocar::engine`, without the
//! delay of a link), so the same samples give the same commands, bit for bit. The controller needs no allocator, no
//! operating system and no standard library, and does the same work at every good sample outside of an event.
//!
//! ```
//! # use trocar_core as trocar;
//! use trocar::rig::{HapticController, Sample, Settings};
//!
//! let mut controller = HapticController::new(&Settings { contact_m: 0.012, ..Settings::default() })?;
//! // At each tick of the rig, 1 ms apart:
//! let command = controller.step(&Sample {
//!     master_position_m: 0.015,
//!     slave_position_m: 0.0149,
//!     slave_velocity_m_per_s: 0.01,
//!     force_n: 1.2,
//! });
//! // To the slave's position controller and to the master's force controller.
//! assert_eq!((command.slave_reference_m, command.master_force_n), (0.015, 1.2));
//! assert!(!command.alarm && !command.faults.any());
//! # Ok::<(), trocar::error::InvalidValue>(())
//! ```
//!
//! # Impossible samples
//! A number that is not finite, or beyond its limit in [`Limits`], is a fault of its channel. At such a tick
//!
//! - the channel's last good value replaces it. Before the first good value the rig counts as at rest at
//!   [`Settings::start_m`], without force;
//! - estimator and detector skip the sample: no alarm is raised, the estimate does not change, and no correction spans
//!   the gap. The detector treats the gap as a loss of contact and is armed again after
//!   [`ArmingSettings::settle_s`](crate::detector::ArmingSettings) of quiet contact. A rupture within that time is
//!   missed;
//! - the supervisor's timers continue, so an event ends on time;
//! - [`Command::faults`] names the channels, and [`Command::faulty_samples`] counts the consecutive bad samples.
//!
//! When good samples return, the slave's reference returns to the hand and the feedback force to the measured force, no
//! faster than [`Limits::recovery_speed_m_per_s`] and [`Limits::recovery_force_rate_n_per_s`]. Holding the last value
//! is not safe for long: the builder of the rig decides after how many bad samples the motors are switched off.

mod held;
mod sample;
mod settings;

pub use sample::{Command, Faults, Sample};
pub use settings::{Limits, Settings, VelocitySource};

use crate::augmentation::{Supervisor, SupervisorInput};
use crate::chain::{Chain, ChainOutput, Measurement};
use crate::detector::CusumDetector;
use crate::error::InvalidValue;
use crate::estimation::{Estimate, Rls, VelocityFilter};
use crate::lane::{Lane, Stored};
use held::HeldMeasurement;

/// The haptic controller of a rig.
#[derive(Debug, Clone)]
pub struct HapticController {
    chain: Chain<f64, Rls<f64>, CusumDetector<f64>>,
    supervisor: Supervisor<f64>,
    velocity_filter: Option<VelocityFilter<f64>>,
    position_scale: f64,
    force_scale: f64,
    limits: Limits,
    tick: u64,
    /// The supervisor's last inputs, which replace bad values.
    hand_m: HeldMeasurement,
    /// The hand's last position, scaled to the slave in m, and the factor from its change in a tick to the master's
    /// velocity.
    last_hand_m: f64,
    per_hand_step: f64,
    force_n: HeldMeasurement,
    slave_m: f64,
    velocity_m_per_s: f64,
    /// `K` in N/m and `B` in N·s/m.
    parameters: [f64; 2],
    faulty_samples: u32,
    /// True if the last sample was bad or a held value has not yet returned to its reading.
    is_disturbed: bool,
}

impl HapticController {
    /// Creates a controller in teleoperation.
    ///
    /// # Errors
    /// [`InvalidValue`] naming the first setting out of range.
    pub fn new(settings: &Settings) -> Result<Self, InvalidValue> {
        settings.validate()?;
        let Settings { tick_s, start_m, limits, .. } = *settings;
        let velocity_filter = match settings.velocity {
            VelocitySource::Measured => None,
            VelocitySource::Filtered { resolution_m, acceleration_std_m_per_s2 } => {
                Some(VelocityFilter::new(tick_s, resolution_m, acceleration_std_m_per_s2)?)
            }
        };
        let reference_m = settings.position_scale * start_m;
        let threshold = settings.detector.cusum.threshold;
        Ok(Self {
            chain: Chain {
                contact_m: settings.contact_m,
                estimator: Rls::new(&settings.estimator),
                detector: CusumDetector::new(&settings.detector, tick_s),
            },
            supervisor: Supervisor::new(&settings.augmentation, threshold, tick_s, reference_m),
            velocity_filter,
            position_scale: settings.position_scale,
            force_scale: settings.force_scale,
            limits,
            tick: 0,
            last_hand_m: reference_m,
            per_hand_step: 1.0 / (settings.position_scale * tick_s),
            hand_m: HeldMeasurement::at(reference_m, limits.recovery_speed_m_per_s * tick_s),
            force_n: HeldMeasurement::at(0.0, limits.recovery_force_rate_n_per_s * tick_s),
            slave_m: reference_m,
            velocity_m_per_s: 0.0,
            parameters: [0.0; 2],
            faulty_samples: 0,
            is_disturbed: false,
        })
    }

    /// Processes the sample of a tick and returns its command. For a tick without a sample pass [`Sample::MISSING`].
    ///
    /// Every number of the command is finite, for any sample.
    #[inline]
    pub fn step(&mut self, sample: &Sample) -> Command {
        let faults = self.faults(sample);
        if faults.any() | self.is_disturbed {
            return self.step_disturbed(sample, faults);
        }
        self.slave_m = sample.slave_position_m;
        self.velocity_m_per_s = match &mut self.velocity_filter {
            Some(filter) => filter.update(sample.slave_position_m),
            None => sample.slave_velocity_m_per_s,
        };
        let output = self.chain.step(&self.measurement(sample.force_n));
        self.parameters = [output.estimate.stiffness_n_per_m, output.estimate.damping_n_s_per_m];
        let hand_m = self.hand_m.pass(self.position_scale * sample.master_position_m);
        let force_n = self.force_n.pass(self.force_scale * sample.force_n);
        self.command(&output, hand_m, force_n, faults)
    }

    /// The number of processed samples.
    #[must_use]
    pub fn ticks(&self) -> u64 {
        self.tick
    }

    /// The estimator's gain `F`, symmetric, as (F₀₀, F₀₁, F₁₁): the covariance of (`K`, `B`) up to a factor.
    #[must_use]
    pub fn estimator_gain(&self) -> [f64; 3] {
        self.chain.estimator.gain()
    }

    #[inline(always)]
    fn faults(&self, sample: &Sample) -> Faults {
        let Limits { position_m, velocity_m_per_s, force_n, .. } = self.limits;
        // NaN exceeds every limit.
        let is_beyond = |value: f64, limit: f64| !value.abs().le(limit);
        Faults {
            master_position: is_beyond(sample.master_position_m, position_m),
            slave_position: is_beyond(sample.slave_position_m, position_m),
            slave_velocity: is_beyond(sample.slave_velocity_m_per_s, velocity_m_per_s) & self.velocity_filter.is_none(),
            force: is_beyond(sample.force_n, force_n),
        }
    }

    /// The last good position and velocity of the slave, with a force (N).
    #[inline(always)]
    fn measurement(&self, force_n: f64) -> Measurement<f64> {
        Measurement { force_n, position_m: self.slave_m, velocity_m_per_s: self.velocity_m_per_s }
    }

    #[inline(always)]
    fn command(&mut self, output: &ChainOutput<f64>, hand_m: f64, force_n: f64, faults: Faults) -> Command {
        let ChainOutput { estimate, decision, .. } = output;
        let input = SupervisorInput {
            tick: self.tick,
            alarm: decision.alarm,
            decision: decision.decision,
            hand_m,
            slave_m: self.slave_m,
            force_n,
        };
        let velocity_m_per_s = (hand_m - self.last_hand_m) * self.per_hand_step;
        self.last_hand_m = hand_m;
        let command = self.supervisor.update(&input, force_n, velocity_m_per_s);
        self.tick += 1;
        Command {
            slave_reference_m: command.slave_reference_m,
            master_force_n: command.feedback_force_n,
            allowed_force_step_n: command.allowed_step_n,
            mode: command.mode.lane(0),
            alarm: decision.alarm,
            alarm_taken: command.alarm_taken,
            stiffness_n_per_m: estimate.stiffness_n_per_m,
            damping_n_s_per_m: estimate.damping_n_s_per_m,
            predicted_force_n: estimate.predicted_force_n,
            residual_n: estimate.residual_n,
            distance: decision.distance,
            decision: decision.decision,
            slave_velocity_m_per_s: self.velocity_m_per_s,
            faults,
            faulty_samples: self.faulty_samples,
        }
    }

    /// Processes a tick whose sample is bad, follows a bad one, or falls into a recovery.
    #[cold]
    #[inline(never)]
    fn step_disturbed(&mut self, sample: &Sample, faults: Faults) -> Command {
        let follows_a_bad_one = self.faulty_samples > 0;
        self.faulty_samples = if faults.any() { self.faulty_samples.saturating_add(1) } else { 0 };

        if !faults.slave_position {
            self.slave_m = sample.slave_position_m;
            self.velocity_m_per_s = match &mut self.velocity_filter {
                Some(filter) if follows_a_bad_one => filter.resume(sample.slave_position_m),
                Some(filter) => filter.update(sample.slave_position_m),
                None if faults.slave_velocity => self.velocity_m_per_s,
                None => sample.slave_velocity_m_per_s,
            };
        }
        let output = if faults.any() || follows_a_bad_one {
            self.skip_sample(sample, faults)
        } else {
            self.chain.step(&self.measurement(sample.force_n))
        };
        self.parameters = [output.estimate.stiffness_n_per_m, output.estimate.damping_n_s_per_m];

        let hand_m = match faults.master_position {
            true => self.hand_m.hold(),
            false => self.hand_m.recover(self.position_scale * sample.master_position_m),
        };
        let force_n = match faults.force {
            true => self.force_n.hold(),
            false => self.force_n.recover(self.force_scale * sample.force_n),
        };
        self.is_disturbed = faults.any() || !(self.hand_m.is_recovered() && self.force_n.is_recovered());
        self.command(&output, hand_m, force_n, faults)
    }

    /// Handles a bad sample or the first good one after it: no residual, no correction, no alarm.
    fn skip_sample(&mut self, sample: &Sample, faults: Faults) -> ChainOutput<f64> {
        let decision = if faults.any() {
            self.chain.skip(if faults.force { 0.0 } else { sample.force_n }, self.velocity_m_per_s)
        } else {
            self.chain.resume(&self.measurement(sample.force_n))
        };
        let [stiffness_n_per_m, damping_n_s_per_m] = self.parameters;
        let estimate = Estimate {
            predicted_force_n: 0.0,
            residual_n: 0.0,
            correction: [0.0; 2],
            stiffness_n_per_m,
            damping_n_s_per_m,
            extra_parameter: 0.0,
        };
        ChainOutput { depth_m: 0.0, estimate, decision }
    }
}

impl Stored for HapticController {
    fn numbers(&mut self, with: &mut dyn FnMut(&mut u64)) {
        // Without `..`, so that a new field must be stored or, like these four, follow from the settings.
        let Self {
            chain,
            supervisor,
            velocity_filter,
            position_scale: _,
            force_scale: _,
            limits: _,
            tick,
            hand_m,
            last_hand_m,
            per_hand_step: _,
            force_n,
            slave_m,
            velocity_m_per_s,
            parameters,
            faulty_samples,
            is_disturbed,
        } = self;
        chain.numbers(with);
        supervisor.numbers(with);
        velocity_filter.numbers(with);
        tick.numbers(with);
        hand_m.numbers(with);
        last_hand_m.numbers(with);
        force_n.numbers(with);
        slave_m.numbers(with);
        velocity_m_per_s.numbers(with);
        parameters.numbers(with);
        faulty_samples.numbers(with);
        is_disturbed.numbers(with);
    }
}

#[cfg(test)]
mod tests;
