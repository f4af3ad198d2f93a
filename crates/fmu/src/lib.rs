//! The library inside the units that `trocar export fmu` writes: the functions of FMI 2.0 and 3.0 for co-simulation, around
//! [`trocar_studies::fmu::Instance`].
//!
//! Names and arguments are those of the standard (<https://fmi-standard.org>), which is their documentation. No panic leaves a
//! function: it ends as an error of the instance.

#![allow(non_snake_case, reason = "the names of the standard")]
#![allow(missing_docs, reason = "the functions are documented by the standard")]

mod component;
mod fmi2;
mod fmi3;
