//! Estimator, detector and supervisor for a real controller. The simulator runs the same source, bit for bit.
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
//! # Bad samples
//! In a channel with a fault ([`Command::faults`]: not finite, or beyond its limit in [`Limits`]) the last good value
//! replaces the sample; timers continue.
//!
//! The step of a good sample interpolates up to [`Limits::bridged_samples`] missing ones before it. After a longer gap
//! the detector starts anew and misses ruptures until [`ArmingSettings::settle_s`](crate::detector::ArmingSettings) of
//! quiet contact has passed.
//!
//! # Safety
//! Before the first good sample the reference is [`Settings::start_m`], scaled; from then on it starts at the slave:
//! switch on the motors after that sample.

mod counters;
mod detection;
mod held;
mod needle;
mod sample;
mod sequence;
mod settings;

pub use counters::Counters;
pub use detection::DetectionState;
pub use needle::{Detection, NeedleDetector, NeedleSample};
pub use sample::{Command, Faults, Sample};
pub use settings::{Limits, Settings, VelocitySource};

use crate::augmentation::{Supervisor, SupervisorInput};
use crate::chain::Measurement;
use crate::error::InvalidValue;
use crate::lane::Stored;
use crate::safety::{Safe, SafetyCounts, SafetyStage, SafetyState, SlaveSample, Wanted};
use detection::{Detected, DetectionChain};
use held::HeldMeasurement;
use sequence::Sequence;
use settings::is_beyond;

/// The haptic controller of a rig.
#[derive(Debug, Clone)]
pub struct HapticController {
    detection: DetectionChain,
    sequence: Sequence,
    supervisor: Supervisor<f64>,
    safety: SafetyStage,
    reads_velocity: bool,
    position_scale: f64,
    force_scale: f64,
    limits: Limits,
    tick: u64,
    hand_m: HeldMeasurement,
    /// Scaled to the slave; `per_hand_step` gives the master's velocity.
    last_hand_m: f64,
    per_hand_step: f64,
    force_n: HeldMeasurement,
    slave_m: f64,
    faulty_samples: u32,
    counters: Counters,
    is_disturbed: bool,
}

impl HapticController {
    /// Starts in teleoperation.
    pub fn new(settings: &Settings) -> Result<Self, InvalidValue> {
        settings.validate()?;
        let Settings { tick_s, start_m, limits, .. } = *settings;
        let reference_m = settings.position_scale * start_m;
        let threshold = settings.detector.cusum.threshold;
        Ok(Self {
            reads_velocity: settings.velocity.is_measured(),
            detection: DetectionChain::of(settings)?,
            sequence: Sequence::default(),
            supervisor: Supervisor::new(&settings.augmentation, threshold, tick_s, reference_m),
            safety: SafetyStage::new(&settings.safety, tick_s, reference_m),
            position_scale: settings.position_scale,
            force_scale: settings.force_scale,
            limits,
            tick: 0,
            last_hand_m: reference_m,
            per_hand_step: 1.0 / (settings.position_scale * tick_s),
            hand_m: HeldMeasurement::at(reference_m, limits.recovery_speed_m_per_s * tick_s),
            force_n: HeldMeasurement::at(0.0, limits.recovery_force_rate_n_per_s * tick_s),
            slave_m: reference_m,
            faulty_samples: 0,
            counters: Counters::default(),
            is_disturbed: false,
        })
    }

    /// Processes a sample, or [`Sample::MISSING`]; every number of the command is finite.
    #[inline]
    pub fn step(&mut self, sample: &Sample) -> Command {
        let number = self.sequence.advance();
        self.step_new(sample, number)
    }

    /// Numbers start at 1, one per tick; a repeated or lower one counts as missing, until ten ascending ones show that
    /// the counter was set back.
    pub fn step_numbered(&mut self, sample: &Sample, number: u64) -> Command {
        let arrival = self.sequence.take(number);
        self.counters.note(arrival);
        self.step_new(if arrival.is_new() { sample } else { &Sample::MISSING }, number)
    }

    #[inline(always)]
    fn step_new(&mut self, sample: &Sample, number: u64) -> Command {
        let faults = self.faults(sample);
        if faults.any() | self.is_disturbed | !self.detection.is_next(number) {
            return self.step_disturbed(sample, number, faults);
        }
        self.slave_m = sample.slave_position_m;
        let detected = self.detection.step(&measurement(sample), number);
        let hand_m = self.hand_m.pass(self.position_scale * sample.master_position_m);
        let force_n = self.force_n.pass(self.force_scale * sample.force_n);
        self.command(&detected, hand_m, force_n, faults, Some(&self.slave_sample(sample)))
    }

    /// See [`SafetyStage::stop`].
    pub fn stop(&mut self) {
        self.safety.stop();
    }

    /// See [`SafetyStage::enable`].
    pub fn enable(&mut self) {
        self.safety.enable();
    }

    /// State of the commands.
    #[must_use]
    pub fn safety_state(&self) -> SafetyState {
        self.safety.state()
    }

    /// Counts of limited ticks and of faults.
    #[must_use]
    pub fn safety_counts(&self) -> SafetyCounts {
        self.safety.counts()
    }

    /// Number of processed samples.
    #[must_use]
    pub fn ticks(&self) -> u64 {
        self.tick
    }

    /// (F₀₀, F₀₁, F₁₁): the covariance of (`K`, `B`) up to a factor.
    #[must_use]
    pub fn estimator_gain(&self) -> [f64; 3] {
        self.detection.estimator_gain()
    }

    /// Counts of bad, stale and lost samples.
    #[must_use]
    pub fn counters(&self) -> Counters {
        let (bridged, gaps) = self.detection.gaps();
        Counters { bridged, gaps, ..self.counters }
    }

    #[inline(always)]
    fn faults(&self, sample: &Sample) -> Faults {
        Faults {
            master_position: is_beyond(sample.master_position_m, self.limits.position_m),
            ..self.limits.slave_faults(&measurement(sample), self.reads_velocity)
        }
    }

    #[inline(always)]
    fn slave_sample(&self, sample: &Sample) -> SlaveSample {
        SlaveSample {
            position_m: sample.slave_position_m,
            velocity_m_per_s: self.reads_velocity.then_some(sample.slave_velocity_m_per_s),
            force_n: sample.force_n,
        }
    }

    #[inline(always)]
    fn command(
        &mut self,
        detected: &Detected,
        hand_m: f64,
        force_n: f64,
        faults: Faults,
        sample: Option<&SlaveSample>,
    ) -> Command {
        let Detected { estimate, decision } = detected;
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
        let wanted = Wanted {
            reference_m: command.slave_reference_m,
            force_n: command.feedback_force_n,
            slave_m: self.slave_m,
            is_good: !faults.any(),
        };
        let Safe { reference_m, force_n, limited } = self.safety.pass(&wanted, sample);
        self.tick += 1;
        let (detection, detection_ticks) = self.detection.state();
        Command {
            slave_reference_m: reference_m,
            master_force_n: force_n,
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
            slave_velocity_m_per_s: self.detection.velocity_m_per_s(),
            faults,
            faulty_samples: self.faulty_samples,
            detection,
            detection_ticks,
            state: self.safety.state(),
            fault: self.safety.cause(),
            limited,
        }
    }

    #[cold]
    #[inline(never)]
    fn step_disturbed(&mut self, sample: &Sample, number: u64, faults: Faults) -> Command {
        self.faulty_samples = if faults.any() { self.faulty_samples.saturating_add(1) } else { 0 };
        self.counters.bad += u64::from(faults.any());

        if !faults.slave_position {
            self.slave_m = sample.slave_position_m;
        }
        let detected = self.detection.take(&measurement(sample), number, faults.of_slave());

        let hand_m = match faults.master_position {
            true => self.hand_m.hold(),
            false => self.hand_m.recover(self.position_scale * sample.master_position_m),
        };
        let force_n = match faults.force {
            true => self.force_n.hold(),
            false => self.force_n.recover(self.force_scale * sample.force_n),
        };
        self.is_disturbed = faults.any() || !(self.hand_m.is_recovered() && self.force_n.is_recovered());
        let of_slave = (!faults.of_slave()).then(|| self.slave_sample(sample));
        self.command(&detected, hand_m, force_n, faults, of_slave.as_ref())
    }
}

#[inline(always)]
fn measurement(sample: &Sample) -> Measurement<f64> {
    Measurement {
        force_n: sample.force_n,
        position_m: sample.slave_position_m,
        velocity_m_per_s: sample.slave_velocity_m_per_s,
    }
}

impl Stored for HapticController {
    fn numbers(&mut self, with: &mut dyn FnMut(&mut u64)) {
        let Self {
            detection,
            sequence,
            supervisor,
            safety,
            reads_velocity: _,
            position_scale: _,
            force_scale: _,
            limits: _,
            tick,
            hand_m,
            last_hand_m,
            per_hand_step: _,
            force_n,
            slave_m,
            faulty_samples,
            counters,
            is_disturbed,
        } = self;
        detection.numbers(with);
        sequence.numbers(with);
        supervisor.numbers(with);
        safety.numbers(with);
        tick.numbers(with);
        hand_m.numbers(with);
        last_hand_m.numbers(with);
        force_n.numbers(with);
        slave_m.numbers(with);
        faulty_samples.numbers(with);
        counters.numbers(with);
        is_disturbed.numbers(with);
    }
}

#[cfg(test)]
mod tests;
