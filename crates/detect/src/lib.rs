//! Runs the estimator and the detector on the position, velocity and force of a recording or a live stream.

pub mod calibration;
mod chain;
mod conditions;
pub mod document;
mod even;
mod live;
mod matching;
mod misses;
mod offset;
mod phases;
mod plausibility;
mod report;
mod scores;
mod stages;
mod statistics;

pub use chain::{ASSUMED_STEP_M, DetectionChain, Step, VelocitySource};
pub use conditions::SampleConditions;
pub use document::{column_values, live_text};
pub use live::{LiveDetector, LiveStep, LiveSummary, TimestampAnomaly};
pub use matching::{Match, match_alarms};
pub use misses::LabelMiss;
pub use phases::{Phase, PhaseInterval, PhaseRule};
pub use plausibility::{recorded_warnings, sampling_rate};
pub use report::{DetectedAlarm, DetectionReport, ExtraParameterEstimate, Label};
pub use scores::{Scores, Tally};
pub use statistics::{PhaseStatistics, ResidualStatistics};
pub use trocar_core::chain::Measurement;

use even::{Samples, samples};
use plausibility::{Plausibility, Signals};
use stages::{Decisions, evaluate};

use trocar_base::warning::Warning;
use trocar_core::detector::DetectorSettings;
use trocar_core::error::InvalidValue;
use trocar_engine::engine::TrustColumns;
use trocar_recording::Recording;
use trocar_scenario::{DetectionSettings, DetectionSpec};

/// One value per sample.
#[derive(Debug, Clone, PartialEq)]
pub struct Detection {
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
    /// Column name and values.
    pub extra_parameter: Option<(&'static str, Vec<f64>)>,
    pub alarms: Vec<usize>,
    pub contact_m: f64,
    /// Below the contact at any time.
    pub touched: bool,
    pub conditions: Vec<SampleConditions>,
    pub detector: DetectorSettings,
    /// False if the velocities are estimated from the positions.
    pub is_velocity_measured: bool,
    pub is_resampled: bool,
    pub notes: Vec<String>,
    pub warnings: Vec<Warning>,
    pub phases: Vec<PhaseInterval>,
    recorded: Plausibility,
}

impl Detection {
    pub fn trust(&self) -> TrustColumns {
        let parameters = (&*self.stiffness_n_per_m, &*self.damping_n_s_per_m);
        let motion = (&*self.position_m, &*self.velocity_m_per_s);
        TrustColumns::of((self.contact_m, self.interval_s), motion, &self.residual_n, parameters)
    }
}

/// Smaller changes of the position are rounding.
const MIN_STEP_M: f64 = 1e-9;

/// Resamples an uneven recording. A Kalman filter replaces missing velocities.
pub fn detect(spec: &DetectionSpec) -> Result<Detection, InvalidValue> {
    detect_recording(spec.recording.recording.clone(), &spec.settings)
}

/// [`detect`] without a copy.
pub fn detect_recording(recording: Recording, settings: &DetectionSettings) -> Result<Detection, InvalidValue> {
    let samples = samples(recording);
    let interval_s = samples.interval_s;
    let filtered =
        || VelocitySource::Filtered { step_m: position_step_m(&samples.position_m, settings.position_resolution_m) };
    let is_velocity_measured = samples.velocity_m_per_s.is_some();
    let velocity = if is_velocity_measured { VelocitySource::Measured } else { filtered() };
    let mut chain = DetectionChain::new(settings, interval_s, velocity)?;
    let signals = Signals::of(&samples, interval_s, settings);
    let of_samples = || {
        let phases = PhaseRule::default().split(signals.position_m, interval_s, settings.contact_m);
        (phases, Plausibility::of(&signals))
    };
    // In parallel: the second closure takes a third of the chain's time.
    let ((estimates, decisions), (phases, recorded)) = rayon::join(|| evaluate(&mut chain, &signals), of_samples);
    let Samples { time_s, position_m, velocity_m_per_s: measured, force_n, is_resampled, notes, warnings, .. } =
        samples;
    let [residual_n, stiffness_n_per_m, damping_n_s_per_m, velocity_m_per_s, extra] = estimates.into_columns();
    let Decisions { columns, conditions, alarms, touched } = decisions;
    let [distance, decision] = columns.into_columns();
    Ok(Detection {
        interval_s,
        time_s,
        position_m,
        velocity_m_per_s: measured.unwrap_or(velocity_m_per_s),
        measured_force_n: force_n,
        residual_n,
        stiffness_n_per_m,
        damping_n_s_per_m,
        distance,
        decision,
        extra_parameter: settings.estimator.extra_parameter_column().map(|name| (name, extra)),
        alarms,
        contact_m: settings.contact_m,
        touched,
        conditions,
        detector: settings.detector,
        is_velocity_measured,
        is_resampled,
        notes,
        warnings,
        phases,
        recorded,
    })
}

/// The given step, else the smallest change between two samples.
fn position_step_m(position_m: &[f64], given_m: f64) -> f64 {
    if given_m > 0.0 {
        return given_m;
    }
    let steps = position_m.windows(2).map(|pair| (pair[1] - pair[0]).abs()).filter(|step| *step > MIN_STEP_M);
    steps.reduce(f64::min).unwrap_or(ASSUMED_STEP_M)
}
