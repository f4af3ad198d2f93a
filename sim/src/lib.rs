//! Simulation of bilateral teleoperation of needle insertions with event-based haptic augmentation.
//!
//! The crate `trocar` adds drawing, printing and serving, and re-exports this crate under the same names. Use that one.

pub use trocar_core::{augmentation, chain, detection, error, estimation, lane, rig, settings, time};

pub mod channel;
pub mod compare;
pub mod detect;
pub mod engine;
pub mod fmu;
pub mod interrupt;
#[doc(hidden)]
pub mod large_pages;
pub mod lti;
pub mod metrics;
mod moments;
pub mod operator;
#[doc(hidden)]
pub mod parallel;
pub mod plant;
pub mod population;
#[doc(hidden)]
pub mod quantiles;
pub mod recording;
pub mod remote;
pub mod roc;
#[doc(hidden)]
pub mod rows;
pub mod run;
pub mod scenario;
pub mod sensor;
pub mod stability;
pub mod stability_check;
pub mod sweep;
pub mod teleoperation;
pub mod tissue;
pub mod warning;
