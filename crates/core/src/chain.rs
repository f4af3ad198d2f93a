//! The detection chain: estimator → distance → decision.

use crate::detector::{AlarmConditions, CusumDetector, Decision, Detector, DetectorInput, Distance};
use crate::estimation::{Estimate, Estimator};
use crate::lane::{Lane, Mask};

/// The slave's measured values.
#[derive(Debug, Clone, Copy)]
pub struct Measurement<L> {
    /// Positive when the tissue resists insertion.
    pub force_n: L,
    /// Increasing into the tissue.
    pub position_m: L,
    /// In m/s.
    pub velocity_m_per_s: L,
}

impl Measurement<f64> {
    /// Interpolates linearly; `share` is 0 here and 1 at `next`.
    #[inline]
    #[must_use]
    pub fn between(&self, next: &Self, share: f64) -> Self {
        let mix = |from: f64, to: f64| from + (to - from) * share;
        Self {
            force_n: mix(self.force_n, next.force_n),
            position_m: mix(self.position_m, next.position_m),
            velocity_m_per_s: mix(self.velocity_m_per_s, next.velocity_m_per_s),
        }
    }
}

/// Output at one sample.
#[derive(Debug, Clone, Copy)]
pub struct ChainOutput<L: Lane> {
    /// Below the contact.
    pub depth_m: L,
    /// Output of the estimator.
    pub estimate: Estimate<L>,
    /// Output of the detector.
    pub decision: Decision<L>,
}

/// Constant time and memory per sample.
#[derive(Debug, Clone)]
pub struct Chain<L, E, D> {
    /// Tissue surface assumed by the estimator.
    pub contact_m: L,
    /// The estimator.
    pub estimator: E,
    /// The detector.
    pub detector: D,
}

/// The first stage of a [`Chain`].
#[derive(Debug)]
pub struct Estimation<'a, L, E> {
    contact_m: L,
    estimator: &'a mut E,
}

impl<L: Lane, E: Estimator<L>> Estimation<'_, L, E> {
    /// Returns the estimate and the detector's input.
    #[inline(always)]
    pub fn step(&mut self, measurement: &Measurement<L>) -> (Estimate<L>, DetectorInput<L>) {
        let Measurement { force_n, position_m, velocity_m_per_s } = *measurement;
        let depth_m = position_m - self.contact_m;
        let estimate = self.estimator.update(force_n, depth_m, velocity_m_per_s);
        let input = DetectorInput::new(force_n, depth_m, velocity_m_per_s, &estimate);
        (estimate, input)
    }
}

impl<L: Lane, E: Estimator<L>, D: Detector<L>> Chain<L, E, D> {
    /// Processes the next sample.
    #[inline(always)]
    pub fn step(&mut self, measurement: &Measurement<L>) -> ChainOutput<L> {
        let (mut estimation, detector) = self.stages();
        let (estimate, input) = estimation.step(measurement);
        ChainOutput { depth_m: input.depth_m, estimate, decision: detector.update(&input) }
    }

    /// The estimator does not depend on the detector, so it can run ahead.
    #[inline(always)]
    pub fn stages(&mut self) -> (Estimation<'_, L, E>, &mut D) {
        (Estimation { contact_m: self.contact_m, estimator: &mut self.estimator }, &mut self.detector)
    }

    /// A missing sample: no new estimate, no alarm, no contact.
    pub fn skip(&mut self, force_n: L, velocity_m_per_s: L) -> Decision<L> {
        self.estimator.skip();
        let zero = L::zero();
        let decision = self.detector.update(&DetectorInput {
            force_n,
            predicted_force_n: zero,
            residual_n: zero,
            correction: [zero; 2],
            depth_m: zero,
            velocity_m_per_s,
            in_contact: L::Mask::splat(false),
        });
        Decision { alarm: L::Mask::splat(false), ..decision }
    }

    /// The first sample after a gap has no prediction and counts as missing.
    pub fn resume(&mut self, measurement: &Measurement<L>) -> Decision<L> {
        let Measurement { force_n, position_m, velocity_m_per_s } = *measurement;
        let decision = self.skip(force_n, velocity_m_per_s);
        self.estimator.update(force_n, position_m - self.contact_m, velocity_m_per_s);
        decision
    }
}

impl<L: Lane, E: Estimator<L>, D: Distance<L>> Chain<L, E, CusumDetector<L, D>> {
    /// [`Chain::step`], with the conditions on an alarm.
    #[inline]
    pub fn step_with_conditions(&mut self, measurement: &Measurement<L>) -> (ChainOutput<L>, AlarmConditions<L>) {
        let (mut estimation, detector) = self.stages();
        let (estimate, input) = estimation.step(measurement);
        let conditions = detector.conditions(&input);
        (ChainOutput { depth_m: input.depth_m, estimate, decision: detector.update(&input) }, conditions)
    }
}

impl<E: crate::lane::Gather, D: crate::lane::Gather> crate::lane::Gather for Chain<f64, E, D> {
    type Of<L: Lane> = Chain<L, E::Of<L>, D::Of<L>>;

    fn gather<L: Lane>(all: [&Self; crate::lane::LANES]) -> Option<Self::Of<L>> {
        use crate::lane::{Gather, of_each};
        Some(Chain {
            contact_m: Gather::gather(of_each!(all, |one| &one.contact_m))?,
            estimator: E::gather(of_each!(all, |one| &one.estimator))?,
            detector: D::gather(of_each!(all, |one| &one.detector))?,
        })
    }
}

impl<E: crate::lane::Stored, D: crate::lane::Stored> crate::lane::Stored for Chain<f64, E, D> {
    fn numbers(&mut self, with: &mut dyn FnMut(&mut u64)) {
        let Self { contact_m, estimator, detector } = self;
        contact_m.numbers(with);
        estimator.numbers(with);
        detector.numbers(with);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::detector::{DetectorSettings, SquaredResidual};
    use crate::estimation::{Rls, RlsSettings};

    /// An estimator with a force of 100 N/m that counts the samples and the gaps.
    #[derive(Clone, Default)]
    struct Hundred {
        samples: u32,
        gaps: u32,
    }

    impl Estimator<f64> for Hundred {
        fn update(&mut self, force_n: f64, depth_m: f64, velocity_m_per_s: f64) -> Estimate<f64> {
            self.samples += 1;
            let predicted_force_n = 100.0 * depth_m;
            Estimate {
                predicted_force_n,
                residual_n: force_n - predicted_force_n,
                correction: [1.0, 2.0],
                stiffness_n_per_m: 100.0,
                damping_n_s_per_m: velocity_m_per_s,
                extra_parameter: 0.0,
            }
        }
        fn skip(&mut self) {
            self.gaps += 1;
        }
    }

    /// A detector that keeps its inputs and raises an alarm at every sample.
    #[derive(Clone, Default)]
    struct Always(Vec<DetectorInput<f64>>);

    impl Detector<f64> for Always {
        fn update(&mut self, input: &DetectorInput<f64>) -> Decision<f64> {
            self.0.push(*input);
            Decision { distance: 3.0, decision: 4.0, alarm: true }
        }
    }

    const MEASUREMENT: Measurement<f64> = Measurement { force_n: 1.75, position_m: 0.03, velocity_m_per_s: 0.5 };

    fn chain() -> Chain<f64, Hundred, Always> {
        Chain { contact_m: 0.02, estimator: Hundred::default(), detector: Always::default() }
    }

    #[test]
    fn a_sample_goes_through_the_estimator_at_its_depth_and_its_input_to_the_detector() {
        let mut chain = chain();
        let output = chain.step(&MEASUREMENT);
        assert!((output.depth_m - 0.01).abs() < 1e-15 && (output.estimate.residual_n - 0.75).abs() < 1e-12);
        assert!(output.decision.alarm && output.estimate.damping_n_s_per_m == 0.5);
        let input = chain.detector.0[0];
        assert_eq!((input.force_n, input.velocity_m_per_s, input.in_contact), (1.75, 0.5, true));
        assert!((input.depth_m - 0.01).abs() < 1e-15 && (input.residual_n - 0.75).abs() < 1e-12);
        let mut outside = self::chain();
        outside.step(&Measurement { position_m: 0.01, ..MEASUREMENT });
        assert!(!outside.detector.0[0].in_contact);
    }

    #[test]
    fn a_missing_sample_is_a_gap_for_the_estimator_a_loss_of_contact_for_the_detector_and_no_alarm() {
        let mut chain = chain();
        let decision = chain.skip(2.5, -0.25);
        assert!(!decision.alarm && decision.decision == 4.0);
        assert_eq!((chain.estimator.samples, chain.estimator.gaps), (0, 1));
        let input = chain.detector.0[0];
        assert_eq!((input.force_n, input.velocity_m_per_s, input.in_contact), (2.5, -0.25, false));
        assert_eq!((input.residual_n, input.predicted_force_n, input.depth_m), (0.0, 0.0, 0.0));
    }

    #[test]
    fn the_first_sample_after_a_gap_counts_as_missing_but_updates_the_estimator() {
        let mut chain = chain();
        assert!(!chain.resume(&MEASUREMENT).alarm);
        assert_eq!((chain.estimator.samples, chain.estimator.gaps), (1, 1));
        assert_eq!((chain.detector.0.len(), chain.detector.0[0].in_contact), (1, false));
    }

    #[test]
    fn the_returned_conditions_are_from_before_the_sample() {
        let settings = DetectorSettings::default();
        let chain = || Chain {
            contact_m: 0.0,
            estimator: Rls::<f64>::new(&RlsSettings::default()),
            detector: CusumDetector::<f64, SquaredResidual<f64>>::with_distance(
                SquaredResidual::new(),
                &settings,
                1e-3,
            ),
        };
        let (mut with, mut without) = (chain(), chain());
        for k in 0..400 {
            let depth_m = 0.01 + 1e-5 * f64::from(k);
            let force_n = 200.0 * depth_m - if k >= 300 { 1.0 } else { 0.0 };
            let measurement = Measurement { force_n, position_m: depth_m, velocity_m_per_s: 0.01 };
            let (output, conditions) = with.step_with_conditions(&measurement);
            let plain = without.step(&measurement);
            assert_eq!(output.decision.alarm, plain.decision.alarm, "{k}");
            assert_eq!(output.estimate.residual_n, plain.estimate.residual_n);
            assert_eq!(output.decision.alarm, k == 300, "{k}");
            if k == 300 {
                assert!(conditions.all(), "an alarm needs all of them");
            }
        }
    }
}
