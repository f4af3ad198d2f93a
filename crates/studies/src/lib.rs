//! What is done with scenarios: runs, comparisons, detection in recordings, evaluation of detectors, sweeps, the comparison of the
//! stability analysis with simulations, and units for co-simulation.
//!
//! It may use every package of the simulator but `trocar-link`; it draws and prints nothing. The crate `trocar` re-exports it.

pub mod animation;
pub mod compare;
pub mod fmu;
pub mod reference;
pub mod roc;
pub mod run;
pub mod stability_check;
pub mod sweep;
