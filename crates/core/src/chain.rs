//! The detection chain: estimator → distance → decision, one sample at a time.
//!
//! The engine, the rig, `detect`, `calibrate` and `roc` all run this chain.

use crate::detection::{AlarmConditions, CusumDetector, Decision, Detector, Distance, Evidence};
use crate::estimation::{Estimate, Estimator};
use crate::lane::{Lane, Mask};

/// The slave's measured values at one sample.
#[derive(Debug, Clone, Copy)]
pub struct Reading<L> {
    /// Force on the needle in N, positive when it resists insertion.
    pub force_n: L,
    /// Position of the needle in m, growing into the tissue.
    pub position_m: L,
    /// Velocity of the needle in m/s.
    pub velocity_m_per_s: L,
}

/// The chain's output at one sample.
#[derive(Debug, Clone, Copy)]
pub struct Insight<L: Lane> {
    /// Depth of the needle below the contact in m.
    pub depth_m: L,
    /// Output of the estimator.
    pub estimate: Estimate<L>,
    /// Output of the detector.
    pub decision: Decision<L>,
}

/// An estimator followed by a detector. Memory and time per sample are constant; nothing is allocated.
#[derive(Debug, Clone)]
pub struct Chain<L, E, D> {
    /// Position of the tissue surface assumed by the estimator, in m.
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
    /// Processes the next sample. Returns what the estimator makes of it, and the evidence for the detector.
    #[inline(always)]
    pub fn step(&mut self, reading: &Reading<L>) -> (Estimate<L>, Evidence<L>) {
        let Reading { force_n, position_m, velocity_m_per_s } = *reading;
        let depth_m = position_m - self.contact_m;
        let estimate = self.estimator.update(force_n, depth_m, velocity_m_per_s);
        let evidence = Evidence::new(force_n, depth_m, velocity_m_per_s, &estimate);
        (estimate, evidence)
    }
}

impl<L: Lane, E: Estimator<L>, D: Detector<L>> Chain<L, E, D> {
    /// Processes the next sample.
    #[inline(always)]
    pub fn step(&mut self, reading: &Reading<L>) -> Insight<L> {
        let (mut estimation, detector) = self.stages();
        let (estimate, evidence) = estimation.step(reading);
        Insight { depth_m: evidence.depth_m, estimate, decision: detector.update(&evidence) }
    }

    /// The estimator and the detector, apart: nothing goes back from the detector, so the estimator can be samples ahead.
    #[inline(always)]
    pub fn stages(&mut self) -> (Estimation<'_, L, E>, &mut D) {
        (Estimation { contact_m: self.contact_m, estimator: &mut self.estimator }, &mut self.detector)
    }

    /// Handles a missing sample: the estimate does not change and no alarm is raised. The detector treats it as a loss
    /// of contact at a force (N) and a velocity (m/s).
    pub fn skip(&mut self, force_n: L, velocity_m_per_s: L) -> Decision<L> {
        self.estimator.skip();
        let zero = L::zero();
        let decision = self.detector.update(&Evidence {
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

    /// Processes the first sample after missing ones. There is no prediction for it, so it counts as missing, too; the
    /// next one is predicted from it.
    pub fn resume(&mut self, reading: &Reading<L>) -> Decision<L> {
        let Reading { force_n, position_m, velocity_m_per_s } = *reading;
        let decision = self.skip(force_n, velocity_m_per_s);
        self.estimator.update(force_n, position_m - self.contact_m, velocity_m_per_s);
        decision
    }
}

impl<L: Lane, E: Estimator<L>, D: Distance<L>> Chain<L, E, CusumDetector<L, D>> {
    /// [`Chain::step`], with the conditions on an alarm at this sample.
    #[inline]
    pub fn step_with_conditions(&mut self, reading: &Reading<L>) -> (Insight<L>, AlarmConditions<L>) {
        let (mut estimation, detector) = self.stages();
        let (estimate, evidence) = estimation.step(reading);
        let conditions = detector.conditions(&evidence);
        (Insight { depth_m: evidence.depth_m, estimate, decision: detector.update(&evidence) }, conditions)
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
