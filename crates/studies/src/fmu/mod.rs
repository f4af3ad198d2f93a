//! Scenarios as functional mock-up units for co-simulation (FMI 2.0 and 3.0): variables, description and files.
//!
//! `trocar export fmu` writes a [`Unit`]. The library inside, the package `trocar-fmu`, runs it. Both build the variables
//! from the scenario in the unit.
//!
//! A step from `t` to `t + h` reads the inputs at `t` and computes the ticks from `t` onwards. The outputs are then
//! those of the last tick before `t + h`. With a step of one tick, the command for the sample at `t` is available at `t
//! + h`.

mod description;
mod unit;
mod variables;
mod version;

pub use description::describe;
pub use unit::{Unit, UnitError, token};
pub use variables::{Causality, FIRST_COLUMN, IS_LED, Model, POSITION, STOP, Scalar, Type, Variable, rig_outputs};
pub use version::Version;
