//! Online estimation from samples: the tissue's stiffness and damping, optionally with friction or a power, and the
//! velocity from quantised positions.
//!
//! The estimators have no access to the tissue model: their inputs are measured positions, velocities and forces.

mod any;
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

pub use any::AnyEstimator;
pub use confidence::{Confidence, Trust};
pub use estimator::{Estimate, Estimator};
pub use friction::Friction;
pub use hunt_crossley::HuntCrossley;
pub use least_residual::LeastResidual;
pub use linear::Linear;
pub use rls::Rls;
pub use settings::{ContactSettings, Forgetting, FrictionShape, MAX_FORGETTING_FACTOR, Parameters, RlsSettings};
pub use velocity::VelocityFilter;
