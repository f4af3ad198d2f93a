//! The estimator and the detector on the position, velocity and force of a recording or a live stream.

pub mod calibration;
mod chain;
mod conditions;
mod live;
mod matching;
mod misses;
mod phases;
mod plausibility;
mod report;
mod scores;
mod statistics;

pub use crate::chain::Reading;
pub use chain::{ASSUMED_STEP_M, DetectionChain, Step, VelocitySource};
pub use conditions::SampleConditions;
pub use live::{LiveDetector, LiveStep, LiveSummary, TimestampAnomaly};
pub use matching::{Match, match_alarms};
pub use misses::LabelMiss;
pub use phases::{Phase, PhaseInterval, PhaseRule};
pub use plausibility::sampling_rate;
pub use report::{DetectedAlarm, DetectionReport, ExtraParameterEstimate, Label};
pub use scores::{Scores, Tally};
pub use statistics::{PhaseStatistics, ResidualStatistics};

use crate::detection::DetectorSettings;
use crate::engine::TrustColumns;
use crate::error::InvalidValue;
use crate::interrupt;
use crate::recording::{Recording, ResampleError};
use crate::scenario::{DetectionSettings, DetectionSpec};

/// The estimates and decisions for a recording, with a value per sample.
#[derive(Debug, Clone, PartialEq)]
#[allow(missing_docs, reason = "the names say quantity and unit, as in a trace")]
pub struct Detection {
    /// Sampling interval, in s.
    pub interval_s: f64,
    pub time_s: Vec<f64>,
    pub position_m: Vec<f64>,
    pub velocity_m_per_s: Vec<f64>,
    pub measured_force_n: Vec<f64>,
    pub residual_n: Vec<f64>,
    pub stiffness_n_per_m: Vec<f64>,
    pub damping_n_s_per_m: Vec<f64>,
    pub distance: Vec<f64>,
    pub decision: Vec<f64>,
    /// Column name and values of the estimator's extra parameter, if any.
    pub extra_parameter: Option<(&'static str, Vec<f64>)>,
    /// Samples with an alarm.
    pub alarms: Vec<usize>,
    /// Contact position, in m.
    pub contact_m: f64,
    /// Whether the needle was ever below the contact.
    pub touched: bool,
    /// The conditions on an alarm.
    pub conditions: Vec<SampleConditions>,
    /// The detector.
    pub detector: DetectorSettings,
    /// Whether the velocities were recorded; otherwise they are estimated from the positions.
    pub is_velocity_measured: bool,
}

impl Detection {
    /// The trust in the estimates, sample by sample.
    #[must_use]
    pub fn trust(&self) -> TrustColumns {
        let parameters = (&*self.stiffness_n_per_m, &*self.damping_n_s_per_m);
        let motion = (&*self.position_m, &*self.velocity_m_per_s);
        TrustColumns::of((self.contact_m, self.interval_s), motion, &self.residual_n, parameters)
    }
}

/// Maximum deviation of an interval from the median one, as a share of it, in an evenly sampled recording.
const EVEN_SHARE: f64 = 0.01;

/// Minimum change of a recorded position that counts as a step of the encoder or of the digits, in m.
const MIN_STEP_M: f64 = 1e-9;

/// Runs the estimator and the detector over a recording, sample by sample.
///
/// Both need evenly spaced samples: an uneven recording is first resampled linearly at its median interval. Without a
/// recorded velocity, a Kalman filter estimates it from the positions. The position step is the smallest change between
/// two samples unless the settings give one.
///
/// # Errors
/// [`InvalidValue`] for a setting out of range.
pub fn detect(spec: &DetectionSpec) -> Result<Detection, InvalidValue> {
    detect_recording(spec.recording.recording.clone(), &spec.settings)
}

/// [`detect`] of a recording that is given up: without a copy, its columns become those of the result.
///
/// # Errors
/// As [`detect`].
pub fn detect_recording(recording: Recording, settings: &DetectionSettings) -> Result<Detection, InvalidValue> {
    let interval_s = recording.median_interval_s();
    let Samples { time_s, position_m, velocity_m_per_s: measured, force_n } = samples(recording);
    let is_velocity_measured = measured.is_some();
    let filtered = || VelocitySource::Filtered { step_m: position_step_m(&position_m, settings.position_resolution_m) };
    let velocity = if is_velocity_measured { VelocitySource::Measured } else { filtered() };
    let mut chain = DetectionChain::new(settings, interval_s, velocity)?;
    let count = time_s.len();
    let column = || Vec::with_capacity(count);
    let mut detection = Detection {
        interval_s,
        time_s,
        position_m,
        velocity_m_per_s: measured.unwrap_or_else(column),
        measured_force_n: force_n,
        residual_n: column(),
        stiffness_n_per_m: column(),
        damping_n_s_per_m: column(),
        distance: column(),
        decision: column(),
        extra_parameter: settings.estimator.extra_parameter_column().map(|name| (name, column())),
        alarms: vec![],
        contact_m: settings.contact_m,
        touched: false,
        conditions: Vec::with_capacity(count),
        detector: settings.detector,
        is_velocity_measured,
    };
    for sample in 0..count {
        interrupt::check_at(sample as u64);
        let step = chain.step(&Reading {
            position_m: detection.position_m[sample],
            velocity_m_per_s: if is_velocity_measured { detection.velocity_m_per_s[sample] } else { 0.0 },
            force_n: detection.measured_force_n[sample],
        });
        detection.touched |= step.depth_m > 0.0;
        if !is_velocity_measured {
            detection.velocity_m_per_s.push(step.velocity_m_per_s);
        }
        detection.residual_n.push(step.estimate.residual_n);
        detection.stiffness_n_per_m.push(step.estimate.stiffness_n_per_m);
        detection.damping_n_s_per_m.push(step.estimate.damping_n_s_per_m);
        if let Some((_, values)) = &mut detection.extra_parameter {
            values.push(step.estimate.extra_parameter);
        }
        detection.distance.push(step.decision.distance);
        detection.decision.push(step.decision.decision);
        detection.conditions.push(SampleConditions::of(&step.conditions));
        if step.decision.alarm {
            detection.alarms.push(sample);
        }
    }
    Ok(detection)
}

/// Evenly spaced samples.
struct Samples {
    time_s: Vec<f64>,
    position_m: Vec<f64>,
    velocity_m_per_s: Option<Vec<f64>>,
    force_n: Vec<f64>,
}

fn samples(recording: Recording) -> Samples {
    let interval_s = recording.median_interval_s();
    let uneven = |pair: &[f64]| (pair[1] - pair[0] - interval_s).abs() > EVEN_SHARE * interval_s;
    let as_recorded = |recording: Recording| {
        let (time_s, position_m, velocity_m_per_s, force_n) = recording.into_columns();
        Samples { time_s, position_m, velocity_m_per_s, force_n }
    };
    if !recording.time_s().windows(2).any(uneven) {
        return as_recorded(recording);
    }
    let resample = |recording: &Recording| {
        let ticks = recording.ticks_covered(interval_s)?;
        let even = recording.resample(interval_s, ticks)?;
        let start_s = recording.time_s().first().copied().unwrap_or(0.0);
        let time_s = (0..ticks).map(|k| start_s + k as f64 * interval_s).collect();
        let (position_m, velocity_m_per_s, force_n) = (even.position_m, even.velocity_m_per_s, even.force_n);
        Ok::<_, ResampleError>(Samples { time_s, position_m, velocity_m_per_s, force_n })
    };
    // The median of ascending times is a valid tick; if resampling fails nevertheless, the samples stay as recorded.
    resample(&recording).unwrap_or_else(|_| as_recorded(recording))
}

/// Returns the position step in m: the given one if it is above 0, else the smallest change between two samples.
fn position_step_m(position_m: &[f64], given_m: f64) -> f64 {
    if given_m > 0.0 {
        return given_m;
    }
    let steps = position_m.windows(2).map(|pair| (pair[1] - pair[0]).abs()).filter(|step| *step > MIN_STEP_M);
    steps.reduce(f64::min).unwrap_or(ASSUMED_STEP_M)
}
