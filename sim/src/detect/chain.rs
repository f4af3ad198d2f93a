//! Velocity filter, estimator and detector in a row, fed sample by sample: what files and live streams share.

use crate::detection::{Decision, Detector, Evidence};
use crate::error::{InvalidValue, positive};
use crate::estimation::{Estimate, Estimator, VelocityFilter};
use crate::scenario::DetectionSettings;

/// The step that is assumed of positions of which nothing else is known, in m.
pub const ASSUMED_STEP_M: f64 = 1e-6;

/// One sample, in SI units and this crate's signs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reading {
    /// Position of the needle in m, growing into the tissue.
    pub position_m: f64,
    /// Velocity in m/s; not looked at where it is filtered from the positions.
    pub velocity_m_per_s: f64,
    /// Force on the needle in N, positive when it resists insertion.
    pub force_n: f64,
}

/// Where the velocity comes from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum VelocitySource {
    /// It is measured.
    Measured,
    /// A Kalman filter estimates it from positions that are read in steps of so many m.
    Filtered {
        /// The step in m, above 0.
        step_m: f64,
    },
}

/// What came of one sample.
#[derive(Debug, Clone, Copy)]
pub struct Step {
    /// The velocity that was used in m/s: measured, or filtered from the positions.
    pub velocity_m_per_s: f64,
    /// Depth below the contact in m; negative before it.
    pub depth_m: f64,
    /// What the estimator made of it.
    pub estimate: Estimate<f64>,
    /// What the detector made of it.
    pub decision: Decision<f64>,
}

/// The chain at work. Memory and time per sample are constant; nothing is allocated after construction.
#[derive(Debug, Clone)]
pub struct Chain {
    contact_m: f64,
    filter: Option<VelocityFilter<f64>>,
    estimator: Estimator<f64>,
    detector: Detector<f64>,
}

impl Chain {
    /// A chain that has seen nothing, for samples `interval_s` apart (s).
    ///
    /// # Errors
    /// [`InvalidValue`] for an interval, or a step of the positions, that is not a positive finite number.
    pub fn new(settings: &DetectionSettings, interval_s: f64, velocity: VelocitySource) -> Result<Self, InvalidValue> {
        positive("simulation.tick_s", interval_s)?;
        let acceleration = settings.acceleration_std_m_per_s2;
        let filter = match velocity {
            VelocitySource::Measured => None,
            VelocitySource::Filtered { step_m } => Some(VelocityFilter::new(interval_s, step_m, acceleration)?),
        };
        Ok(Self {
            contact_m: settings.contact_m,
            filter,
            estimator: Estimator::new(&settings.estimator),
            detector: Detector::new(&settings.detector, interval_s),
        })
    }

    /// Takes the next sample.
    #[inline]
    pub fn step(&mut self, reading: &Reading) -> Step {
        let measured = reading.velocity_m_per_s;
        let velocity = self.filter.as_mut().map_or(measured, |filter| filter.update(reading.position_m));
        let depth_m = reading.position_m - self.contact_m;
        let estimate = self.estimator.update(reading.force_n, depth_m, velocity);
        let decision = self.detector.update(&evidence(reading.force_n, depth_m, velocity, &estimate));
        Step { velocity_m_per_s: velocity, depth_m, estimate, decision }
    }
}

/// What a detector goes by: a force (N) at a depth below the contact (m) and a velocity (m/s), and what the estimator made of
/// them.
#[inline]
#[must_use]
pub fn evidence(force_n: f64, depth_m: f64, velocity_m_per_s: f64, estimate: &Estimate<f64>) -> Evidence<f64> {
    Evidence {
        force_n,
        predicted_force_n: estimate.predicted_force_n,
        residual_n: estimate.residual_n,
        correction: estimate.correction,
        depth_m,
        velocity_m_per_s,
        in_contact: depth_m > 0.0,
    }
}
