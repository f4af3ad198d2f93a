//! The library in the units that `trocar export fmu` writes: the functions of FMI 2.0 and 3.0 for co-simulation, around
//! [`Instance`].
//!
//! The standard (<https://fmi-standard.org>) defines and documents names and arguments. No panic leaves a function; it
//! becomes an error of the instance.

#![allow(non_snake_case, reason = "the names of the standard")]

mod component;
mod fmi2;
mod fmi3;
mod instance;
mod state;

pub use instance::{Instance, InstanceError};
pub use state::SavedState;
