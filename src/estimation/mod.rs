//! Online estimation from samples: the tissue's stiffness and damping, and the velocity from quantised positions.
//!
//! Nothing here knows the tissue: positions, velocities and forces come in as a sensor gives them.

mod rls;
mod velocity;

pub use rls::{Estimate, Parameters, Rls, RlsSettings};
pub use velocity::VelocityFilter;
