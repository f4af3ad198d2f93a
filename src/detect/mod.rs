//! The estimator and the detector on a recording's own position, velocity and force.

mod report;

pub use report::{DetectedAlarm, DetectionReport, ResidualStatistics};

use crate::detection::{Detector, Evidence};
use crate::error::InvalidValue;
use crate::estimation::{Rls, VelocityFilter};
use crate::recording::Recording;
use crate::scenario::DetectionSpec;

/// A recording's estimates and decisions, a value per sample.
#[derive(Debug, Clone, PartialEq)]
#[allow(missing_docs, reason = "the names say quantity and unit, as in a trace")]
pub struct Detection {
    pub time_s: Vec<f64>,
    pub position_m: Vec<f64>,
    pub velocity_m_per_s: Vec<f64>,
    pub measured_force_n: Vec<f64>,
    pub residual_n: Vec<f64>,
    pub stiffness_n_per_m: Vec<f64>,
    pub damping_n_s_per_m: Vec<f64>,
    pub distance: Vec<f64>,
    pub decision: Vec<f64>,
    /// Samples at which a rupture is announced.
    pub alarms: Vec<usize>,
}

/// Runs the estimator and the detector over a recording, sample by sample.
///
/// Where the recording has no velocity, a Kalman filter estimates it from the positions.
///
/// # Errors
/// [`InvalidValue`] for a setting out of range.
pub fn detect(spec: &DetectionSpec) -> Result<Detection, InvalidValue> {
    let recording = &spec.recording.recording;
    let interval_s = recording.median_interval_s();
    let velocity_m_per_s = match recording.velocity_m_per_s() {
        Some(velocity) => velocity.to_vec(),
        None => filtered_velocity(recording, spec)?,
    };
    let mut estimator = Rls::<f64>::new(&spec.estimator);
    let mut detector = Detector::<f64>::new(&spec.detector, interval_s);
    let room = || Vec::with_capacity(recording.len());
    let mut detection = Detection {
        time_s: recording.time_s().to_vec(),
        position_m: recording.position_m().to_vec(),
        velocity_m_per_s,
        measured_force_n: recording.force_n().to_vec(),
        residual_n: room(),
        stiffness_n_per_m: room(),
        damping_n_s_per_m: room(),
        distance: room(),
        decision: room(),
        alarms: vec![],
    };
    for (sample, &force_n) in recording.force_n().iter().enumerate() {
        let depth = recording.position_m()[sample] - spec.contact_m;
        let velocity = detection.velocity_m_per_s[sample];
        let estimate = estimator.update(force_n, depth, velocity);
        let decision = detector.update(&Evidence {
            force_n,
            predicted_force_n: estimate.predicted_force_n,
            residual_n: estimate.residual_n,
            correction: estimate.correction,
            velocity_m_per_s: velocity,
            in_contact: depth > 0.0,
        });
        detection.residual_n.push(estimate.residual_n);
        detection.stiffness_n_per_m.push(estimate.stiffness_n_per_m);
        detection.damping_n_s_per_m.push(estimate.damping_n_s_per_m);
        detection.distance.push(decision.distance);
        detection.decision.push(decision.decision);
        if decision.alarm {
            detection.alarms.push(sample);
        }
    }
    Ok(detection)
}

fn filtered_velocity(recording: &Recording, settings: &DetectionSpec) -> Result<Vec<f64>, InvalidValue> {
    let resolution = if settings.position_resolution_m > 0.0 {
        settings.position_resolution_m
    } else {
        finest_step(recording.position_m()).unwrap_or(1e-6)
    };
    let acceleration = settings.acceleration_std_m_per_s2;
    let mut filter = VelocityFilter::<f64>::new(recording.median_interval_s(), resolution, acceleration)?;
    Ok(recording.position_m().iter().map(|&position| filter.update(position)).collect())
}

/// The smallest change of a recorded position: the step of its encoder or of its digits, in m.
fn finest_step(positions: &[f64]) -> Option<f64> {
    let steps = positions.windows(2).map(|pair| (pair[1] - pair[0]).abs()).filter(|step| *step > 1e-9);
    steps.reduce(f64::min)
}
