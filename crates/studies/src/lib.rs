//! Studies of scenarios: runs, comparisons, evaluation of detectors, sweeps, designs, comparison of the stability analysis with
//! simulations, and units for co-simulation.
//!
//! It uses every package of the simulator except `trocar-link`, and does not draw or print. The crate `trocar`
//! re-exports it.

pub mod animation;
pub mod compare;
pub mod design;
pub mod fmu;
pub mod reference;
pub mod roc;
pub mod run;
pub mod stability_check;
pub mod sweep;
