//! Loads and steps functional mock-up units for co-simulation, in FMI 2.0 and 3.0.
//!
//! [`Fmu::open`] unpacks a unit, reads its description and executes nothing. [`Fmu::load`] loads its library, which is code of
//! others: it can do what the program itself can do. An [`Instance`] is stepped.
//!
//! The functions of the standard are called in `functions_2.rs` and `functions_3.rs` and nowhere else; names, arguments and the
//! order of the calls are those of <https://fmi-standard.org>.

mod container;
mod description;
mod error;
mod fmu;
mod functions_2;
mod functions_3;
mod instance;
mod library;
mod version;

pub use description::{Causality, Description, Type, Variable};
pub use error::FmuError;
pub use fmu::Fmu;
pub use instance::Instance;
pub use version::Version;
