//! Receiver operating characteristics: what a detector finds, how late, and how often it is wrong, against its threshold.
//!
//! A case is a signal with white noise of one seed on its force. The estimator runs over it once; every detector then
//! climbs a [`Ladder`] of thresholds on the estimator's residual, and a [`Tally`] counts its alarms against the labels. As a
//! tally holds whole numbers only, neither the order of the cases nor the number of threads changes anything.
//!
//! What is not defined, as the delay where nothing was announced, is `None`. Where no false alarm was seen, the rate is not
//! 0 but below a bound that the length of what was listened to allows.

mod curve;
mod interval;
mod ladder;
mod rungs;
mod signal;
mod study;
mod tally;

pub use curve::{Curve, Point};
pub use interval::{poisson, wilson};
pub use ladder::Ladder;
pub use signal::{Samples, Signal, SignalKind};
pub use study::{Characteristics, Condition, Study};
pub use tally::Tally;

use thiserror::Error;

use crate::error::InvalidValue;
use crate::run::RunError;
use crate::scenario::ScenarioError;

/// Why there are no characteristics.
#[derive(Debug, Error)]
pub enum RocError {
    /// A scenario or a recording cannot be used as it is written.
    #[error(transparent)]
    Scenario(#[from] ScenarioError),
    /// A setting is out of range.
    #[error(transparent)]
    Setting(#[from] InvalidValue),
    /// A scenario could not be run.
    #[error(transparent)]
    Run(#[from] RunError),
    /// Curves of different detectors cannot be drawn into one.
    #[error("{first} and {second} have different settings of the detector {detector}; judge them apart")]
    DifferentDetectors {
        /// One signal.
        first: String,
        /// Another.
        second: String,
        /// The kind of distance.
        detector: &'static str,
    },
}
