//! The simulated insertion: machines, tissue, operator, sensors and link, the controllers, the engine that steps all of
//! them tick by tick, and observers.
//!
//! It uses `trocar-core`, `trocar-base` and `trocar-lti`, and neither scenario files nor studies.
//! The crate `trocar` re-exports it.
//!
//! Without its feature `dop853`, numerical integration is refused by an error.

// Without an integrator, the equations of the integrated machines are not evaluated.
#![cfg_attr(not(feature = "dop853"), allow(dead_code))]

pub mod channel;
pub mod engine;
pub mod operator;
pub mod plant;
pub mod sensor;
pub mod teleoperation;
pub mod tissue;

/// Lanes of wide instructions. Values require [`engine::InstructionSet::is_available`], so the package `trocar` does
/// not re-export them.
#[cfg(target_arch = "x86_64")]
#[doc(hidden)]
pub mod wide_lanes {
    pub use crate::engine::eight::{Avx2, Avx512};
}
