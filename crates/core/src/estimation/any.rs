//! The list of the built-in estimators.

use super::estimator::{BuiltIn, Estimate, Estimator};
use super::friction::Friction;
use super::hunt_crossley::HuntCrossley;
use super::least_residual::LeastResidual;
use super::linear::Linear;
use super::rls::Rls;
use super::settings::{Forgetting, Parameters, RlsSettings};
use crate::lane::Lane;

/// Defines the enum of the built-in estimators, one line each: the parameters, the forgetting, and the type for them.
macro_rules! estimators {
    ($($(#[$doc:meta])* ($($parameters:ident)|+, $forgetting:pat) => $Part:ident,)*) => {
        /// Any of the built-in estimators.
        #[derive(Debug, Clone)]
        pub enum AnyEstimator<L> {
            $($(#[$doc])* $Part($Part<L>),)*
        }

        impl<L: Lane> AnyEstimator<L> {
            /// The estimator for the parameters and the forgetting of the settings, before the first sample.
            #[must_use]
            pub fn new(settings: &RlsSettings) -> Self {
                match (settings.parameters, settings.forgetting) {
                    $(($(Parameters::$parameters)|+, $forgetting) => Self::$Part(BuiltIn::build(settings)),)*
                }
            }
        }

        impl RlsSettings {
            /// Whether these are the settings of the paper's estimator.
            #[must_use]
            pub fn is_baseline(&self) -> bool {
                match (self.parameters, self.forgetting) {
                    $(($(Parameters::$parameters)|+, $forgetting) => <$Part<f64> as BuiltIn>::IS_BASELINE,)*
                }
            }

            /// Name and unit, as a column name, of the parameter besides stiffness and damping.
            #[must_use]
            pub fn extra_parameter_column(&self) -> Option<&'static str> {
                match (self.parameters, self.forgetting) {
                    $(($(Parameters::$parameters)|+, $forgetting) => <$Part<f64> as BuiltIn>::EXTRA_PARAMETER,)*
                }
            }
        }

        impl<L: Lane> Estimator<L> for AnyEstimator<L> {
            #[inline(always)]
            fn update(&mut self, force_n: L, depth_m: L, velocity_m_per_s: L) -> Estimate<L> {
                match self {
                    $(Self::$Part(part) => part.update(force_n, depth_m, velocity_m_per_s),)*
                }
            }

            #[inline(always)]
            fn skip(&mut self) {
                match self {
                    $(Self::$Part(part) => part.skip(),)*
                }
            }
        }

        crate::lane::gather_variants!(AnyEstimator { $($Part),* } stored);
    };
}

estimators! {
    /// The paper's.
    (StiffnessAndDamping | Stiffness, Forgetting::Resetting) => Rls,
    /// Stiffness and damping with exponential forgetting.
    (StiffnessAndDamping | Stiffness, Forgetting::Exponential { .. }) => Linear,
    /// With an additional friction force.
    (StiffnessDampingFriction, _) => Friction,
    /// The Hunt-Crossley model.
    (HuntCrossley, _) => HuntCrossley,
    /// With and without friction; the smaller residual counts.
    (LeastResidual, _) => LeastResidual,
}
