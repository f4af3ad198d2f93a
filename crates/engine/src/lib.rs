#![cfg_attr(not(feature = "dop853"), allow(dead_code))]

pub mod channel;
pub mod engine;
pub mod operator;
pub mod plant;
pub mod sensor;
pub mod teleoperation;
pub mod tissue;

/// Creating a lane requires [`engine::InstructionSet::is_available`]; the package `trocar` does not re-export them.
#[cfg(target_arch = "x86_64")]
#[doc(hidden)]
pub mod wide_lanes {
    pub use crate::engine::eight::{Avx2, Avx512};
}
