//! Loads and steps functional mock-up units for co-simulation, in FMI 2.0 and 3.0.
//!
//! [`Fmu::open`] unpacks a unit and reads its description, without executing anything. [`Fmu::load`] loads its library:
//! third-party code with all permissions of the program.
//!
//! Only `functions_2.rs` and `functions_3.rs` call functions of the standard. Names, arguments and the order of the
//! calls follow <https://fmi-standard.org>.

mod container;
mod description;
mod error;
mod fmu;
mod functions_2;
mod functions_3;
mod instance;
mod library;
mod markup;
mod version;

pub use description::{Causality, Description, Type, Variable};
pub use error::FmuError;
pub use fmu::Fmu;
pub use instance::Instance;
pub use version::Version;
