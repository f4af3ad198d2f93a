//! The simulated insertion: machines, tissue, operator, sensors and link, the controllers between them, the engine that steps all of
//! them tick by tick, and the metrics that observers take from it.
//!
//! It may use `trocar-core`, `trocar-base`, `trocar-lti` and `trocar-fmu-import`. It knows no files of scenarios and no studies. The
//! crate `trocar` re-exports it.

pub mod channel;
pub mod engine;
pub mod metrics;
pub mod operator;
pub mod plant;
pub mod sensor;
pub mod teleoperation;
pub mod tissue;
