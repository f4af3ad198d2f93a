use super::detection::{Detected, DetectionChain};
use super::sequence::Sequence;
use super::{Counters, DetectionState, Faults, Limits, Settings};
use crate::chain::Measurement;
use crate::error::InvalidValue;

/// Measurements of a needle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NeedleSample {
    /// `x_e`, increasing into the tissue.
    pub position_m: f64,
    /// `v_e`; ignored with [`VelocitySource::Filtered`](super::VelocitySource).
    pub velocity_m_per_s: f64,
    /// `y`, positive when the tissue resists insertion.
    pub force_n: f64,
}

impl NeedleSample {
    /// Every channel counts as bad.
    pub const MISSING: Self = Self { position_m: f64::NAN, velocity_m_per_s: f64::NAN, force_n: f64::NAN };
}

/// Every number is finite.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Detection {
    /// True if this sample raises an alarm.
    pub alarm: bool,
    /// `K`.
    pub stiffness_n_per_m: f64,
    /// `B`.
    pub damping_n_s_per_m: f64,
    /// `ŷ`; 0 without a prediction.
    pub predicted_force_n: f64,
    /// `e = y - ŷ`; 0 at a bad sample and at the next one.
    pub residual_n: f64,
    /// `s`.
    pub distance: f64,
    /// `g`.
    pub decision: f64,
    /// `v_e` used by the estimator.
    pub velocity_m_per_s: f64,
    /// Without `master_position`.
    pub faults: Faults,
    /// Consecutive bad samples, this one included.
    pub faulty_samples: u32,
    /// State of the detection.
    pub state: DetectionState,
    /// Ticks since `state` began.
    pub state_ticks: u32,
}

/// The detection of [`HapticController`](super::HapticController), bit for bit.
#[derive(Debug, Clone)]
pub struct NeedleDetector {
    chain: DetectionChain,
    sequence: Sequence,
    limits: Limits,
    reads_velocity: bool,
    faulty_samples: u32,
    counters: Counters,
}

impl NeedleDetector {
    /// Uses only the keys of estimator, detector, sensor, tick and `rig.`.
    pub fn new(settings: &Settings) -> Result<Self, InvalidValue> {
        settings.validate()?;
        Ok(Self {
            chain: DetectionChain::of(settings)?,
            sequence: Sequence::default(),
            limits: settings.limits,
            reads_velocity: settings.velocity.is_measured(),
            faulty_samples: 0,
            counters: Counters::default(),
        })
    }

    /// Processes a sample, or [`NeedleSample::MISSING`].
    #[inline]
    pub fn step(&mut self, sample: &NeedleSample) -> Detection {
        let number = self.sequence.advance();
        self.step_new(sample, number)
    }

    /// As [`HapticController::step_numbered`](super::HapticController::step_numbered).
    pub fn step_numbered(&mut self, sample: &NeedleSample, number: u64) -> Detection {
        let arrival = self.sequence.take(number);
        self.counters.note(arrival);
        self.step_new(if arrival.is_new() { sample } else { &NeedleSample::MISSING }, number)
    }

    /// Counts of bad, stale and lost samples.
    #[must_use]
    pub fn counters(&self) -> Counters {
        let (bridged, gaps) = self.chain.gaps();
        Counters { bridged, gaps, ..self.counters }
    }

    fn step_new(&mut self, sample: &NeedleSample, number: u64) -> Detection {
        let NeedleSample { position_m, velocity_m_per_s, force_n } = *sample;
        let measurement = Measurement { force_n, position_m, velocity_m_per_s };
        let faults = self.limits.slave_faults(&measurement, self.reads_velocity);
        self.faulty_samples = if faults.any() { self.faulty_samples.saturating_add(1) } else { 0 };
        self.counters.bad += u64::from(faults.any());
        let Detected { estimate, decision } = self.chain.take(&measurement, number, faults.any());
        let (state, state_ticks) = self.chain.state();
        Detection {
            alarm: decision.alarm,
            stiffness_n_per_m: estimate.stiffness_n_per_m,
            damping_n_s_per_m: estimate.damping_n_s_per_m,
            predicted_force_n: estimate.predicted_force_n,
            residual_n: estimate.residual_n,
            distance: decision.distance,
            decision: decision.decision,
            velocity_m_per_s: self.chain.velocity_m_per_s(),
            faults,
            faulty_samples: self.faulty_samples,
            state,
            state_ticks,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::{HapticController, Sample};
    use super::*;

    /// Samples of a needle that enters a stiff layer and breaks through, with missing, repeated and lost ones.
    #[test]
    fn the_detector_alone_gives_the_results_of_the_controller_bit_for_bit() {
        let settings = Settings { contact_m: 0.002, ..Settings::default() };
        let mut controller = HapticController::new(&settings).expect("valid");
        let mut detector = NeedleDetector::new(&settings).expect("valid");
        let (mut alarms, mut bad, mut number) = (0, 0, 0);
        for k in 0..4000_u32 {
            number += if k % 1301 == 5 { 12 } else { u64::from(k % 97 != 3) };
            let position_m = 1e-5 * f64::from(k);
            let depth_m = position_m - 0.002;
            let stiffness = if (0.0..0.02).contains(&depth_m) { 200.0 } else { 20.0 };
            let noise_n = 0.002 * libm::sin(1.7 * f64::from(k));
            let force_n = if depth_m > 0.0 { stiffness * depth_m + noise_n } else { noise_n };
            let force_n = if k % 503 == 7 { f64::NAN } else { force_n };
            let sample = NeedleSample { position_m, velocity_m_per_s: 0.01, force_n };
            let found = detector.step_numbered(&sample, number);
            let expected = controller.step_numbered(
                &Sample {
                    master_position_m: position_m,
                    slave_position_m: position_m,
                    slave_velocity_m_per_s: 0.01,
                    force_n,
                },
                number,
            );
            let numbers = [
                (found.stiffness_n_per_m, expected.stiffness_n_per_m),
                (found.damping_n_s_per_m, expected.damping_n_s_per_m),
                (found.predicted_force_n, expected.predicted_force_n),
                (found.residual_n, expected.residual_n),
                (found.distance, expected.distance),
                (found.decision, expected.decision),
                (found.velocity_m_per_s, expected.slave_velocity_m_per_s),
            ];
            assert!(numbers.iter().all(|(found, expected)| found.to_bits() == expected.to_bits()), "{k}: {numbers:?}");
            assert_eq!((found.alarm, found.faulty_samples), (expected.alarm, expected.faulty_samples), "{k}");
            assert_eq!((found.state, found.state_ticks), (expected.detection, expected.detection_ticks), "{k}");
            assert_eq!(found.faults, Faults { master_position: false, ..expected.faults }, "{k}");
            alarms += u32::from(found.alarm);
            bad += u32::from(found.faults.any());
        }
        assert_eq!(detector.counters(), controller.counters());
        assert!(alarms >= 1 && bad > 40, "{alarms} alarms, {bad} bad samples");
    }

    #[test]
    fn a_setting_out_of_range_is_refused() {
        let settings = Settings { contact_m: f64::NAN, ..Settings::default() };
        assert_eq!(NeedleDetector::new(&settings).expect_err("no number").name, "estimator.contact_m");
    }
}
