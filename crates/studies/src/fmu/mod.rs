//! Scenarios as functional mock-up units for co-simulation (FMI 2.0 and 3.0): variables, description, files and
//! instances.
//!
//! `trocar export fmu` writes a [`Unit`]; the library inside runs an [`Instance`]. Both build the variables from the
//! scenario in the unit. The package `trocar-fmu` contains the functions of the standard.
//!
//! A step from `t` to `t + h` reads the inputs at `t` and computes the ticks from `t` onwards. The outputs are then
//! those of the last tick before `t + h`. With a step of one tick, the command for the sample at `t` is available at `t
//! + h`.

mod description;
mod instance;
mod state;
mod unit;
mod variables;

pub use description::describe;
pub use instance::{Instance, InstanceError};
pub use state::SavedState;
pub use trocar_fmu_import::Version;
pub use unit::{Unit, UnitError};
pub use variables::{Causality, Model, Scalar, Type, Variable};
