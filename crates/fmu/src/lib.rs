//! The FMI 2.0 and 3.0 functions for co-simulation around [`Instance`], in the units of `trocar export fmu`.
//!
//! The standard (<https://fmi-standard.org>) documents names and arguments. A panic becomes an error of the instance.

#![allow(non_snake_case, reason = "the names of the standard")]

mod component;
mod fmi2;
mod fmi3;
mod instance;
mod state;

pub use instance::{Instance, InstanceError};
pub use state::SavedState;
