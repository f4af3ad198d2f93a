//! Errors of the stability analysis.

use thiserror::Error;

use trocar_core::error::InvalidValue;
use trocar_engine::plant::PlantError;
use trocar_lti as lti;

/// An error of the stability analysis.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum StabilityError {
    /// A side cannot be built.
    #[error(transparent)]
    Plant(#[from] PlantError),
    /// A parameter is out of range.
    #[error(transparent)]
    Parameter(#[from] InvalidValue),
    /// A numerical failure of the linear algebra.
    #[error("the linear algebra of the loop failed: {0}")]
    Algebra(#[from] lti::Error),
    /// The phase of the response changes too fast to be tracked.
    #[error("the phase of the loop's response cannot be tracked in {evaluations} evaluations; shorten the delay")]
    TooFast {
        /// Number of evaluations.
        evaluations: usize,
    },
    /// The one-tick matrix would be too large.
    #[error("the loop over {ticks} ticks of delay has {states} states, at most {max}; shorten the delay")]
    TooLarge {
        /// Round-trip delay in ticks.
        ticks: u64,
        /// Number of states of the matrix.
        states: u64,
        /// Maximum number of states.
        max: u64,
    },
    /// The tables of measured frequency responses cannot be used.
    #[error("the measured responses cannot be used: {reason}")]
    Measured {
        /// The reason, with a remedy.
        reason: &'static str,
    },
    /// The augmentation has a part without a linear map.
    #[error("the certificate does not cover a part of the augmentation")]
    UncoveredEvents,
    /// The semidefinite solver failed.
    #[error("the search for a certificate failed: the solver reports {status}")]
    Solver {
        /// The solver's status.
        status: String,
    },
}
