//! The list of the built-in estimators.

use super::estimator::{BuiltIn, Estimate, Estimator};
use super::settings::{Forgetting, Parameters, RlsSettings};
use super::{friction, hunt_crossley, least_residual, linear, rls};
use crate::lane::Lane;

crate::registry! {
    /// The kind of an estimator, which follows from its parameters and its forgetting.
    #[derive(Debug, Clone, Copy)]
    enum EstimatorKind;
    /// Any of the built-in estimators.
    pub enum AnyEstimator<L> by (each, of_kind) stored;

    /// The paper's.
    Rls = rls::Rls,
    /// Stiffness and damping with exponential forgetting.
    Linear = linear::Linear,
    /// With an additional friction force.
    Friction = friction::Friction,
    /// The Hunt-Crossley model.
    HuntCrossley = hunt_crossley::HuntCrossley,
    /// With and without friction; the smaller residual counts.
    LeastResidual = least_residual::LeastResidual,
}

impl RlsSettings {
    fn kind(&self) -> EstimatorKind {
        match (self.parameters, self.forgetting) {
            (Parameters::StiffnessAndDamping | Parameters::Stiffness, Forgetting::Resetting) => EstimatorKind::Rls,
            (Parameters::StiffnessAndDamping | Parameters::Stiffness, Forgetting::Exponential { .. }) => {
                EstimatorKind::Linear
            }
            (Parameters::StiffnessDampingFriction, _) => EstimatorKind::Friction,
            (Parameters::HuntCrossley, _) => EstimatorKind::HuntCrossley,
            (Parameters::LeastResidual, _) => EstimatorKind::LeastResidual,
        }
    }

    /// Whether these are the settings of the paper's estimator.
    #[must_use]
    pub fn is_baseline(&self) -> bool {
        of_kind!(self.kind(), Part => <Part<f64> as BuiltIn>::IS_BASELINE)
    }

    /// Name and unit, as a column name, of the parameter besides stiffness and damping.
    #[must_use]
    pub fn extra_parameter_column(&self) -> Option<&'static str> {
        of_kind!(self.kind(), Part => <Part<f64> as BuiltIn>::EXTRA_PARAMETER)
    }
}

impl<L: Lane> AnyEstimator<L> {
    /// The estimator for the parameters and the forgetting of the settings, before the first sample.
    #[must_use]
    pub fn new(settings: &RlsSettings) -> Self {
        of_kind!(settings.kind(), Part => <Part<L> as BuiltIn>::build(settings).into())
    }
}

impl<L: Lane> Estimator<L> for AnyEstimator<L> {
    #[inline(always)]
    fn update(&mut self, force_n: L, depth_m: L, velocity_m_per_s: L) -> Estimate<L> {
        each!(self, estimator => estimator.update(force_n, depth_m, velocity_m_per_s))
    }

    #[inline(always)]
    fn skip(&mut self) {
        each!(self, estimator => estimator.skip());
    }
}
