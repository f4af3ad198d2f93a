//! The estimator of a run: the paper's, or one of the other models.

use super::friction::Friction;
use super::hunt_crossley::HuntCrossley;
use super::least_residual::LeastResidual;
use super::linear::Linear;
use super::rls::{Estimate, Parameters, Rls, RlsSettings};
use super::settings::Forgetting;
use crate::lane::Lane;

/// An estimator with the parameters and the forgetting that its settings ask for.
///
/// The paper's ([`Rls`]) is kept apart from the others, so that the tick that is compiled for it never asks which it is.
#[derive(Debug, Clone)]
pub struct Estimator<L> {
    papers: Rls<L>,
    other: Option<Other<L>>,
}

#[derive(Debug, Clone)]
enum Other<L> {
    Linear(Linear<L>),
    Friction(Friction<L>),
    HuntCrossley(HuntCrossley<L>),
    LeastResidual(LeastResidual<L>),
}

impl<L: Lane> Estimator<L> {
    /// An estimator that knows nothing yet.
    #[must_use]
    pub fn new(settings: &RlsSettings) -> Self {
        let other = match (settings.parameters, settings.forgetting) {
            (Parameters::StiffnessAndDamping | Parameters::Stiffness, Forgetting::Resetting) => None,
            (Parameters::StiffnessAndDamping | Parameters::Stiffness, Forgetting::Exponential { .. }) => {
                Some(Other::Linear(Linear::new(settings)))
            }
            (Parameters::StiffnessDampingFriction, _) => Some(Other::Friction(Friction::new(settings))),
            (Parameters::HuntCrossley, _) => Some(Other::HuntCrossley(HuntCrossley::new(settings))),
            (Parameters::LeastResidual, _) => Some(Other::LeastResidual(LeastResidual::new(settings))),
        };
        Self { papers: Rls::new(settings), other }
    }

    /// Whether it is the paper's, so that [`Estimator::update_papers`] may be called.
    #[must_use]
    pub fn is_baseline(&self) -> bool {
        self.other.is_none()
    }

    /// Takes the sample: force `y` (N), depth `p` below the contact (m), velocity `v` (m/s).
    #[inline(always)]
    pub fn update(&mut self, force_n: L, depth_m: L, velocity_m_per_s: L) -> Estimate<L> {
        match &mut self.other {
            None => self.papers.update(force_n, depth_m, velocity_m_per_s),
            Some(other) if L::WIDTH > 1 => other.update_here(force_n, depth_m, velocity_m_per_s),
            Some(other) => other.update(force_n, depth_m, velocity_m_per_s),
        }
    }

    /// [`Estimator::update`] for those that have asked [`Estimator::is_baseline`] before.
    #[inline(always)]
    pub fn update_papers(&mut self, force_n: L, depth_m: L, velocity_m_per_s: L) -> Estimate<L> {
        self.papers.update(force_n, depth_m, velocity_m_per_s)
    }
}

impl<L: Lane> Other<L> {
    /// Apart from the tick's straight way.
    #[cold]
    #[inline(never)]
    fn update(&mut self, force_n: L, depth_m: L, velocity_m_per_s: L) -> Estimate<L> {
        self.update_here(force_n, depth_m, velocity_m_per_s)
    }

    /// In line, as a call would take lanes side by side out of their registers.
    #[inline(always)]
    fn update_here(&mut self, force_n: L, depth_m: L, velocity_m_per_s: L) -> Estimate<L> {
        match self {
            Self::Linear(model) => model.update(force_n, depth_m, velocity_m_per_s),
            Self::Friction(model) => model.update(force_n, depth_m, velocity_m_per_s),
            Self::HuntCrossley(model) => model.update(force_n, depth_m, velocity_m_per_s),
            Self::LeastResidual(model) => model.update(force_n, depth_m, velocity_m_per_s),
        }
    }
}

crate::lane::gather!(Estimator { papers, other });
crate::lane::gather_variants!(Other { Linear, Friction, HuntCrossley, LeastResidual });
