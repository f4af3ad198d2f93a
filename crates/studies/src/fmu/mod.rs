//! A scenario as a functional mock-up unit for co-simulation (FMI 2.0 and 3.0): its variables, its description, its files, and an
//! instance that is stepped.
//!
//! [`Unit`] is what `trocar export fmu` writes, [`Instance`] what the library inside the unit runs; both build the variables from the
//! scenario inside the unit. The functions of the standard are in the package `trocar-fmu`.
//!
//! A step from `t` to `t + h` reads the inputs of `t` and computes the tick (or ticks) from `t` on: after it, the outputs are those
//! of the last tick before `t + h`. With a step of
//! one tick, the command of the sample at `t` stands at `t + h`.

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
