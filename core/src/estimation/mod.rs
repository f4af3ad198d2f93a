//! Online estimation from samples: the tissue's stiffness and damping, with friction or a power where wanted, and the
//! velocity from quantised positions.
//!
//! Nothing here knows the tissue: positions, velocities and forces come in as a sensor gives them.

mod any;
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
pub use estimator::{Estimate, Estimator};
pub use friction::Friction;
pub use hunt_crossley::HuntCrossley;
pub use least_residual::LeastResidual;
pub use linear::Linear;
pub use rls::Rls;
pub use settings::{ContactSettings, Forgetting, FrictionShape, MAX_FORGETTING_FACTOR, Parameters, RlsSettings};
pub use velocity::VelocityFilter;
