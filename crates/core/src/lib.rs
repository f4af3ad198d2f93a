//! Online estimation of the tissue, detection of ruptures and haptic augmentation for a real controller ([`rig`]), one
//! step per sample, without operating system, allocator and standard library.
//!
//! Equation numbers refer to Barbé, Bayle, de Mathelin and Gangi, *In Vivo Model Estimation and Haptic Characterization
//! of Needle Insertions*.

#![warn(missing_docs)]
#![cfg_attr(not(test), no_std)]

#[cfg(feature = "alloc")]
extern crate alloc;

// The macros of `settings` refer to `trocar_core`.
extern crate self as trocar_core;

pub mod augmentation;
pub mod chain;
pub mod detector;
pub mod error;
pub mod estimation;
pub mod friction;
pub mod lane;
mod registry;
pub mod rig;
pub mod safety;
#[doc(hidden)]
pub mod set_back;
pub mod settings;
pub mod time;
