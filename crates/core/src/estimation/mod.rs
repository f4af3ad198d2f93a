//! Online estimation of the tissue's parameters and of the velocity.

mod confidence;
mod estimator;
mod forgetting;
mod friction;
mod hunt_crossley;
mod least_residual;
mod linear;
mod regression;
mod resetting;
mod rls;
mod settings;
mod velocity;

pub use confidence::{Confidence, Trust};
pub use estimator::{Estimate, Estimator};
pub use friction::Friction;
pub use hunt_crossley::HuntCrossley;
pub use least_residual::LeastResidual;
pub use linear::Linear;
pub use rls::Rls;
pub use settings::{ContactSettings, Forgetting, FrictionShape, MAX_FORGETTING_FACTOR, RlsSettings};
pub use velocity::VelocityFilter;

use self::estimator::BuiltIn;
use crate::lane::Lane;

crate::choice! {
    /// Estimated parameters: K and B; K alone, as the paper tries in 3.2.1; K, B and friction; μ, λ and n of eq. 2; or
    /// K and B with and without friction, where the smaller error counts.
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    pub enum Parameters at "estimator.parameters" = StiffnessAndDamping {
        /// `φ = (p, v)` (eq. 8).
        "stiffness-and-damping" => StiffnessAndDamping,
        /// `φ = (p, 0)`, `B = 0` (3.2.1).
        "stiffness" => Stiffness,
        "stiffness-damping-friction" => StiffnessDampingFriction,
        /// Eq. 2.
        "hunt-crossley" => HuntCrossley,
        "least-residual" => LeastResidual,
    }
}

crate::registry! {
    #[derive(Debug, Clone, Copy)]
    enum EstimatorKind;
    /// Any of the built-in estimators.
    pub enum AnyEstimator<L> by (each, of_kind) stored;

    Rls = rls::Rls,
    Linear = linear::Linear,
    Friction = friction::Friction,
    HuntCrossley = hunt_crossley::HuntCrossley,
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

    /// True for the paper's estimator.
    #[must_use]
    pub fn is_baseline(&self) -> bool {
        of_kind!(self.kind(), Part => <Part<f64> as BuiltIn>::IS_BASELINE)
    }

    /// Column of the third parameter.
    #[must_use]
    pub fn extra_parameter_column(&self) -> Option<&'static str> {
        of_kind!(self.kind(), Part => <Part<f64> as BuiltIn>::EXTRA_PARAMETER)
    }
}

impl<L: Lane> AnyEstimator<L> {
    /// The estimator of the settings.
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
