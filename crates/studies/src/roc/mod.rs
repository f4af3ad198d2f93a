//! Receiver operating characteristics: detections, delays and false alarms of a detector by threshold.
//!
//! A case is a signal whose force has white noise of one seed. The estimator runs once per case. Every detector then
//! evaluates the residual with many thresholds, and a [`Tally`] compares the alarms with the labels. Tallies are
//! integers, so the results do not depend on the order of the cases or the threads.
//!
//! An undefined value, such as the delay without a detection, is `None`. Without a false alarm the rate has an upper
//! bound that depends on the observed time.

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

/// The error of a study.
#[derive(Debug, Error)]
pub enum RocError {
    /// A scenario or a recording is invalid.
    #[error(transparent)]
    Scenario(#[from] ScenarioError),
    /// A setting is out of range.
    #[error(transparent)]
    Setting(#[from] InvalidValue),
    /// A run failed.
    #[error(transparent)]
    Run(#[from] RunError),
    /// The signals have different detector settings, and therefore no common curve.
    #[error("{first} and {second} have different settings of the detector {detector}; evaluate them separately")]
    DifferentDetectors {
        /// The first signal.
        first: String,
        /// The second signal.
        second: String,
        /// The kind of distance.
        detector: &'static str,
    },
}
