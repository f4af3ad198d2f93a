//! Scenarios as functional mock-up units for co-simulation (FMI 2.0 and 3.0).
//!
//! A step from `t` to `t + h` reads the inputs at `t` and computes the ticks from `t` onwards. The outputs are those of
//! the last tick before `t + h`: with a step of one tick, the command for the sample at `t` is available at `t + h`.

mod description;
mod unit;
mod variables;
mod version;

pub use description::describe;
pub use unit::{Unit, UnitError, token};
pub use variables::{Causality, FIRST_COLUMN, IS_LED, Model, POSITION, STOP, Scalar, Type, Variable, rig_outputs};
pub use version::Version;
