//! Parameters of a machine, with 95 % intervals, from recordings of it.
//!
//! The slave of a rig follows its master by a controller with a position and a velocity gain. [`identify`] estimates
//! these gains, the moving mass, viscous and Coulomb friction, and the errors of the force sensor. It simulates the
//! slave with the measured master position as input and the measured force as load, and minimises the difference
//! between simulated and measured slave positions (output error), so that noise of the positions does not bias the
//! parameters. Other recordings, which take no part in the estimation, show how well the machine generalises.
//!
//! It may use `trocar-base`, `trocar-recording` and `trocar-document`. The crate `trocar` re-exports it as
//! `trocar::identify`.

mod actuator;
mod document;
mod error;
mod estimate;
mod figure;
mod file;
mod filter;
mod grid;
mod intervals;
mod machine;
mod measured;
mod model;
mod part;
mod plausibility;
mod problem;
mod questions;
mod structure;
mod system;
mod tables;
mod twin;
mod whiteness;
mod zero;

pub use error::IdentifyError;
pub use estimate::{Fit, Identification, Request, Role, STEPS, identify};
pub use file::IdentificationFile;
pub use machine::{Load, Machine};
pub use measured::{MachineColumns, Measured};
pub use part::{Part, PartColumns, PartFit, PartIdentification, PartRequest, Signals, identify_part};
pub use structure::Structure;
pub use whiteness::Whiteness;
