//! The role of the estimator, and the built-in ones.
//!
//! A built-in estimator is one file of this folder, one line of [`estimators!`], and one word of [`Parameters`] where what it
//! estimates is new.

use super::friction::Friction;
use super::hunt_crossley::HuntCrossley;
use super::least_residual::LeastResidual;
use super::linear::Linear;
use super::rls::{Estimate, Rls, RlsSettings};
use super::settings::{Forgetting, Parameters};
use crate::lane::Lane;

/// Learns the tissue from samples, one at a time.
///
/// An estimator of one's own implements this for `f64`; the built-in ones do for any number of lanes.
pub trait Estimator<L: Lane> {
    /// Takes the sample: force `y` (N), depth `p` below the contact (m, negative outside), velocity `v` (m/s).
    ///
    /// The residual of the estimate is that of the prediction that was made before the sample (eq. 6-7).
    fn update(&mut self, force_n: L, depth_m: L, velocity_m_per_s: L) -> Estimate<L>;

    /// Takes note that samples are missing: the next one has no prediction to be compared with.
    fn skip(&mut self);
}

#[cfg(feature = "alloc")]
impl<L: Lane, E: Estimator<L> + ?Sized> Estimator<L> for alloc::boxed::Box<E> {
    fn update(&mut self, force_n: L, depth_m: L, velocity_m_per_s: L) -> Estimate<L> {
        (**self).update(force_n, depth_m, velocity_m_per_s)
    }

    fn skip(&mut self) {
        (**self).skip();
    }
}

/// What a built-in estimator says of itself.
pub(super) trait BuiltIn {
    /// Whether it is the paper's, which a rig runs.
    const IS_BASELINE: bool = false;
    /// What it estimates besides stiffness and damping, as a column's name with its unit.
    const EXTRA_PARAMETER: Option<&'static str> = None;

    /// The estimator of the settings, without any sample.
    fn build(settings: &RlsSettings) -> Self;
}

/// The enum of the built-in estimators, from a line each: the parameters and the forgetting, and the type
/// that is for them.
macro_rules! estimators {
    ($($(#[$doc:meta])* ($($parameters:ident)|+, $forgetting:pat) => $Part:ident,)*) => {
        /// Any of the built-in estimators.
        #[derive(Debug, Clone)]
        pub enum AnyEstimator<L> {
            $($(#[$doc])* $Part($Part<L>),)*
        }

        impl<L: Lane> AnyEstimator<L> {
            /// The estimator with the parameters and the forgetting of the settings, without any sample.
            #[must_use]
            pub fn new(settings: &RlsSettings) -> Self {
                match (settings.parameters, settings.forgetting) {
                    $(($(Parameters::$parameters)|+, $forgetting) => Self::$Part(BuiltIn::build(settings)),)*
                }
            }
        }

        impl RlsSettings {
            /// Whether they are those of the paper's estimator.
            #[must_use]
            pub fn is_baseline(&self) -> bool {
                match (self.parameters, self.forgetting) {
                    $(($(Parameters::$parameters)|+, $forgetting) => <$Part<f64> as BuiltIn>::IS_BASELINE,)*
                }
            }

            /// What is estimated besides stiffness and damping, as a column's name with its unit.
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

        crate::lane::gather_variants!(AnyEstimator { $($Part),* });
    };
}

estimators! {
    /// The paper's.
    (StiffnessAndDamping | Stiffness, Forgetting::Resetting) => Rls,
    /// Stiffness and damping with exponential forgetting.
    (StiffnessAndDamping | Stiffness, Forgetting::Exponential { .. }) => Linear,
    /// With a friction force besides.
    (StiffnessDampingFriction, _) => Friction,
    /// The Hunt-Crossley model.
    (HuntCrossley, _) => HuntCrossley,
    /// With and without friction, the smaller residual counting.
    (LeastResidual, _) => LeastResidual,
}
