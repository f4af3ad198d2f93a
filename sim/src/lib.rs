//! Simulation of bilateral teleoperation of needle insertions with event-based haptic augmentation.
//!
//! This is what the crate `trocar` is made of, apart from what draws, prints and serves. Use that one: it re-exports all of
//! this under the same names.

pub use trocar_core::{augmentation, chain, detection, error, estimation, lane, rig, settings, time};

pub mod channel;
pub mod compare;
pub mod detect;
pub mod engine;
pub mod lti;
pub mod metrics;
mod moments;
pub mod operator;
pub mod plant;
#[doc(hidden)]
pub mod quantiles;
pub mod recording;
pub mod roc;
pub mod run;
pub mod scenario;
pub mod sensor;
pub mod stability;
pub mod stability_check;
pub mod sweep;
pub mod teleoperation;
pub mod tissue;
