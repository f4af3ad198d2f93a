//! Parameters of a machine, with 95 % intervals, from recordings of it.
//!
//! [`identify`] simulates the slave with the measured master position and force, and minimises the error of the slave
//! position (output error), so that position noise does not bias the parameters. [`identify_part`] does the same for a
//! tissue, an arm or a master.

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
