//! Receiver operating characteristics of a detector by threshold.
//!
//! A case is a signal with white noise of one seed. The estimator runs once per case, then every detector evaluates the
//! residual with many thresholds.

mod curve;
mod detector_bank;
mod document;
mod interval;
mod lanes;
mod misses;
mod samples;
mod signal;
mod study;
mod tally;
pub mod trials;

pub use curve::{Curve, Point};
pub use detector_bank::DetectorBank;
pub use document::RocFile;
pub use interval::{poisson, wilson};
pub use samples::Samples;
pub use signal::{Signal, SignalKind};
pub use study::{Characteristics, Condition, Study, UserDefinedPoints};
pub use tally::Tally;

use thiserror::Error;

use crate::run::RunError;
use trocar_core::error::InvalidValue;
use trocar_scenario::ScenarioError;

#[derive(Debug, Error)]
pub enum RocError {
    #[error(transparent)]
    Scenario(#[from] ScenarioError),
    #[error(transparent)]
    Setting(#[from] InvalidValue),
    #[error(transparent)]
    Run(#[from] RunError),
    /// Signals with different detector settings have no common curve.
    #[error("{first} and {second} have different settings of the detector {detector}; evaluate them separately")]
    DifferentDetectors {
        first: String,
        second: String,
        /// Kind of distance.
        detector: &'static str,
    },
}
