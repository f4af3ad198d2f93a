//! The role of the estimator, and the built-in ones.

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

/// The enum of the built-in estimators, from a line each.
macro_rules! estimators {
    ($($(#[$doc:meta])* $Part:ident,)*) => {
        /// Any of the built-in estimators.
        #[derive(Debug, Clone)]
        pub enum AnyEstimator<L> {
            $($(#[$doc])* $Part($Part<L>),)*
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
    Rls,
    /// Stiffness and damping with exponential forgetting.
    Linear,
    /// With a friction force besides.
    Friction,
    /// The Hunt-Crossley model.
    HuntCrossley,
    /// With and without friction, the smaller residual counting.
    LeastResidual,
}

impl<L: Lane> AnyEstimator<L> {
    /// The estimator with the parameters and the forgetting of the settings, without any sample.
    #[must_use]
    pub fn new(settings: &RlsSettings) -> Self {
        match (settings.parameters, settings.forgetting) {
            (Parameters::StiffnessAndDamping | Parameters::Stiffness, Forgetting::Resetting) => {
                Self::Rls(Rls::new(settings))
            }
            (Parameters::StiffnessAndDamping | Parameters::Stiffness, Forgetting::Exponential { .. }) => {
                Self::Linear(Linear::new(settings))
            }
            (Parameters::StiffnessDampingFriction, _) => Self::Friction(Friction::new(settings)),
            (Parameters::HuntCrossley, _) => Self::HuntCrossley(HuntCrossley::new(settings)),
            (Parameters::LeastResidual, _) => Self::LeastResidual(LeastResidual::new(settings)),
        }
    }
}

impl RlsSettings {
    /// Whether they are those of [`Rls`], the paper's estimator.
    #[must_use]
    pub fn is_baseline(&self) -> bool {
        let linear = matches!(self.parameters, Parameters::StiffnessAndDamping | Parameters::Stiffness);
        linear && self.forgetting == Forgetting::Resetting
    }
}
