use super::{AnyDetector, BuiltInOr, Engine, EngineError, ExactPlants, Observer, Parts, Plants, instruction_set};
use crate::operator::{HumanOperator, Operator};
use crate::sensor::AnySensor;
use crate::teleoperation::{Architecture, Connection, DirectLink, PassivityScheme};
use crate::tissue::{AnyTissue, Tissue};
use trocar_core::augmentation::{AnyForceLaw, ForceLaw, HeldReference, MotionLaw};
use trocar_core::detector::{Detector, Distance};
use trocar_core::estimation::{AnyEstimator, Estimator};

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

pub type UserDefinedPlants = BuiltInOr<ExactPlants<f64>, dyn Plants<f64> + Send>;

pub type UserDefinedEngine = Engine<UserDefinedPlants, UserDefinedWiring>;

impl UserDefinedEngine {
    pub fn run_wide(&mut self, mut observer: &mut dyn Observer<f64>) -> Result<(), EngineError> {
        self.run_compiled(&mut observer)
    }

    pub fn run_compiled<O: Observer<f64>>(&mut self, observer: &mut O) -> Result<(), EngineError> {
        instruction_set::run(self, observer)
    }
}

#[derive(Default)]
pub struct UserDefinedParts {
    pub operator: Option<Box<dyn Operator<f64> + Send>>,
    pub tissue: Option<Box<dyn Tissue<f64> + Send>>,
    pub estimator: Option<Box<dyn Estimator<f64> + Send>>,
    pub detector: Option<Box<dyn Detector<f64> + Send>>,
    pub distance: Option<Box<dyn Distance<f64> + Send>>,
    pub architecture: Option<Box<dyn Architecture<f64> + Send>>,
    pub scheme: Option<Box<dyn PassivityScheme<f64> + Send>>,
    pub motion_law: Option<Box<dyn MotionLaw<f64> + Send>>,
    pub force_law: Option<Box<dyn ForceLaw<f64> + Send>>,
}

macro_rules! setters {
    ($($(#[$doc:meta])* $role:ident: $Role:ident,)*) => {
        impl UserDefinedParts {
            $(
                $(#[$doc])*
                pub fn $role(mut self, part: impl $Role<f64> + Send + 'static) -> Self {
                    self.$role = Some(Box::new(part));
                    self
                }
            )*
        }
    };
}

setters! {
    operator: Operator,
    tissue: Tissue,
    estimator: Estimator,
    /// Replaces distance, CUSUM and arming.
    detector: Detector,
    /// Ignored by a user-defined detector.
    distance: Distance,
    architecture: Architecture,
    scheme: PassivityScheme,
    motion_law: MotionLaw,
    force_law: ForceLaw,
}

impl UserDefinedParts {
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
