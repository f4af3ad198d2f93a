use trocar_core::chain::{self, Chain, ChainOutput, Measurement};
use trocar_core::detector::{AlarmConditions, CusumDetector, Decision, DetectorInput};
use trocar_core::error::{InvalidValue, positive, require};
use trocar_core::estimation::{AnyEstimator, Estimate, VelocityFilter};
use trocar_core::lane::Stored;
use trocar_scenario::DetectionSettings;

/// Assumed if no position step is known.
pub const ASSUMED_STEP_M: f64 = 1e-6;

#[derive(Debug, Clone, Copy, PartialEq)]
pub enum VelocitySource {
    Measured,
    /// Estimated by a Kalman filter from positions.
    Filtered {
        /// Above 0.
        step_m: f64,
    },
}

#[derive(Debug, Clone, Copy)]
pub struct Step {
    /// Measured, or filtered from the positions.
    pub velocity_m_per_s: f64,
    /// Below the contact; negative above it.
    pub depth_m: f64,
    pub estimate: Estimate<f64>,
    pub decision: Decision<f64>,
    pub conditions: AlarmConditions<f64>,
}

/// Memory and time per sample are constant.
#[derive(Debug, Clone)]
pub struct DetectionChain {
    filter: Option<VelocityFilter<f64>>,
    chain: Chain<f64, AnyEstimator<f64>, CusumDetector<f64>>,
}

impl DetectionChain {
    pub fn new(settings: &DetectionSettings, interval_s: f64, velocity: VelocitySource) -> Result<Self, InvalidValue> {
        positive("simulation.tick_s", interval_s)?;
        settings.estimator.validate()?;
        settings.detector.validate()?;
        require("estimator.contact_m", settings.contact_m, settings.contact_m.is_finite(), "a finite number")?;
        let acceleration = settings.acceleration_std_m_per_s2;
        let filter = match velocity {
            VelocitySource::Measured => None,
            VelocitySource::Filtered { step_m } => Some(VelocityFilter::new(interval_s, step_m, acceleration)?),
        };
        let estimator = AnyEstimator::new(&settings.estimator);
        let detector = CusumDetector::new(&settings.detector, interval_s);
        Ok(Self { filter, chain: Chain { contact_m: settings.contact_m, estimator, detector } })
    }

    /// After a gap. Only the detector's offset of the sensor remains.
    pub(super) fn restarted(
        self,
        settings: &DetectionSettings,
        interval_s: f64,
        velocity: VelocitySource,
    ) -> Result<Self, InvalidValue> {
        let mut detector = self.chain.detector;
        detector.restart(&settings.detector, interval_s);
        let Self { filter, chain } = Self::new(settings, interval_s, velocity)?;
        Ok(Self { filter, chain: Chain { detector, ..chain } })
    }

    /// A NaN stays in the estimate.
    #[inline]
    pub fn step(&mut self, measurement: &Measurement<f64>) -> Step {
        let measurement = with_velocity(self.filter.as_mut(), measurement);
        let (output, conditions) = self.chain.step_with_conditions(&measurement);
        let ChainOutput { depth_m, estimate, decision } = output;
        Step { velocity_m_per_s: measurement.velocity_m_per_s, depth_m, estimate, decision, conditions }
    }

    pub(super) fn stages(&mut self) -> (Estimation<'_>, &mut CusumDetector<f64>) {
        let (estimation, detector) = self.chain.stages();
        (Estimation { filter: self.filter.as_mut(), estimation }, detector)
    }
}

impl Stored for DetectionChain {
    fn numbers(&mut self, with: &mut dyn FnMut(&mut u64)) {
        let Self { filter, chain } = self;
        filter.numbers(with);
        chain.numbers(with);
    }
}

pub(super) struct Estimation<'a> {
    filter: Option<&'a mut VelocityFilter<f64>>,
    estimation: chain::Estimation<'a, f64, AnyEstimator<f64>>,
}

impl Estimation<'_> {
    #[inline]
    pub(super) fn step(&mut self, measurement: &Measurement<f64>) -> (Estimate<f64>, DetectorInput<f64>) {
        self.estimation.step(&with_velocity(self.filter.as_deref_mut(), measurement))
    }
}

#[inline(always)]
fn with_velocity(filter: Option<&mut VelocityFilter<f64>>, measurement: &Measurement<f64>) -> Measurement<f64> {
    let velocity_m_per_s = filter.map_or(measurement.velocity_m_per_s, |filter| filter.update(measurement.position_m));
    Measurement { velocity_m_per_s, ..*measurement }
}
