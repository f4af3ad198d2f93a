//! User-defined parts in place of built-in ones.

use super::{AnyDetector, BuiltInOr, Engine, EngineError, ExactPlants, Observer, Parts, Plants, instruction_set};
use crate::operator::{HumanOperator, Operator};
use crate::sensor::AnySensor;
use crate::teleoperation::{Architecture, Connection, DirectLink, PassivityScheme};
use crate::tissue::{AnyTissue, Tissue};
use trocar_core::augmentation::{AnyForceLaw, ForceLaw, HeldReference, MotionLaw};
use trocar_core::detector::{Detector, Distance};
use trocar_core::estimation::{AnyEstimator, Estimator};

/// The parts of an engine with user-defined parts, which are called dynamically; built-in parts are inlined.
pub type UserDefinedWiring = Parts<
    f64,
    BuiltInOr<HumanOperator<f64>, dyn Operator<f64> + Send>,
    BuiltInOr<AnyTissue<f64>, dyn Tissue<f64> + Send>,
    AnySensor<f64>,
    BuiltInOr<AnyEstimator<f64>, dyn Estimator<f64> + Send>,
    BuiltInOr<AnyDetector<f64>, dyn Detector<f64> + Send>,
    BuiltInOr<DirectLink<f64>, dyn Connection<f64> + Send>,
    BuiltInOr<HeldReference<f64>, dyn MotionLaw<f64> + Send>,
    BuiltInOr<AnyForceLaw<f64>, dyn ForceLaw<f64> + Send>,
>;

/// The machines of an engine with user-defined parts.
pub type UserDefinedPlants = BuiltInOr<ExactPlants<f64>, dyn Plants<f64> + Send>;

/// An engine with user-defined parts.
pub type UserDefinedEngine = Engine<UserDefinedPlants, UserDefinedWiring>;

impl UserDefinedEngine {
    /// [`Engine::run`] in the widest registers of the machine, if they are faster.
    ///
    /// # Errors
    /// See [`Engine::run`].
    pub fn run_wide(&mut self, mut observer: &mut dyn Observer<f64>) -> Result<(), EngineError> {
        self.run_compiled(&mut observer)
    }

    /// [`UserDefinedEngine::run_wide`], compiled for the observer.
    ///
    /// # Errors
    /// See [`Engine::run`].
    pub fn run_compiled<O: Observer<f64>>(&mut self, observer: &mut O) -> Result<(), EngineError> {
        instruction_set::run(self, observer)
    }
}

/// User-defined parts that replace parts of a scenario.
///
/// ```ignore
/// use trocar::engine::UserDefinedParts;
/// use trocar::run::run_with;
/// use trocar::scenario::{Scenario, Source};
/// use trocar::tissue::{Reaction, Tissue};
///
/// /// A spring with its surface at 0.
/// struct Spring {
///     stiffness_n_per_m: f64,
/// }
///
/// impl Tissue<f64> for Spring {
///     fn react(&mut self, _tick: u64, position_m: f64, _velocity_m_per_s: f64) -> Reaction<f64> {
///         Reaction { force_n: self.stiffness_n_per_m * position_m.max(0.0), ruptured: false }
///     }
/// }
///
/// let scenario = Scenario::load(&Source::parse("paper/classical"), &[])?;
/// let run = run_with(scenario, UserDefinedParts::default().tissue(Spring { stiffness_n_per_m: 200.0 }))?;
/// assert!(run.metrics.max_tissue_force_n.is_some_and(|force| force > 1.0));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Default)]
pub struct UserDefinedParts {
    /// User-defined operator.
    pub operator: Option<Box<dyn Operator<f64> + Send>>,
    /// User-defined tissue.
    pub tissue: Option<Box<dyn Tissue<f64> + Send>>,
    /// User-defined estimator.
    pub estimator: Option<Box<dyn Estimator<f64> + Send>>,
    /// User-defined detector.
    pub detector: Option<Box<dyn Detector<f64> + Send>>,
    /// User-defined distance of the scenario's detector.
    pub distance: Option<Box<dyn Distance<f64> + Send>>,
    /// User-defined architecture.
    pub architecture: Option<Box<dyn Architecture<f64> + Send>>,
    /// User-defined passivity scheme.
    pub scheme: Option<Box<dyn PassivityScheme<f64> + Send>>,
    /// User-defined motion law.
    pub motion_law: Option<Box<dyn MotionLaw<f64> + Send>>,
    /// User-defined force law.
    pub force_law: Option<Box<dyn ForceLaw<f64> + Send>>,
}

/// Defines a setter per role.
macro_rules! setters {
    ($($(#[$doc:meta])* $role:ident: $Role:ident,)*) => {
        impl UserDefinedParts {
            $(
                $(#[$doc])*
                #[must_use]
                pub fn $role(mut self, part: impl $Role<f64> + Send + 'static) -> Self {
                    self.$role = Some(Box::new(part));
                    self
                }
            )*
        }
    };
}

setters! {
    /// Sets the operator, who gives the desired position.
    operator: Operator,
    /// Sets the tissue, which gives the force on the needle.
    tissue: Tissue,
    /// Sets the estimator of the tissue's parameters.
    estimator: Estimator,
    /// Sets the detector of ruptures. It replaces distance, CUSUM and arming.
    detector: Detector,
    /// Sets the distance that the scenario's CUSUM accumulates. A user-defined detector ignores it.
    distance: Distance,
    /// Sets the architecture: the message of each side, and its use by the receiver.
    architecture: Architecture,
    /// Sets the scheme that keeps the link passive.
    scheme: PassivityScheme,
    /// Sets the law of the slave's reference in each mode.
    motion_law: MotionLaw,
    /// Sets the law of the feedback force while the slave is frozen.
    force_law: ForceLaw,
}

impl UserDefinedParts {
    /// The roles with a user-defined part.
    #[must_use]
    pub fn roles(&self) -> Vec<&'static str> {
        let Self { operator, tissue, estimator, detector, distance, architecture, scheme, motion_law, force_law } =
            self;
        let roles = [
            ("operator", operator.is_some()),
            ("tissue", tissue.is_some()),
            ("estimator", estimator.is_some()),
            ("detector", detector.is_some()),
            ("distance", distance.is_some()),
            ("architecture", architecture.is_some()),
            ("scheme", scheme.is_some()),
            ("motion law", motion_law.is_some()),
            ("force law", force_law.is_some()),
        ];
        roles.into_iter().filter(|(_, is_user_defined)| *is_user_defined).map(|(role, _)| role).collect()
    }
}

impl std::fmt::Debug for UserDefinedParts {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_set().entries(self.roles()).finish()
    }
}
