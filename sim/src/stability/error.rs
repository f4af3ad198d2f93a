//! Why a loop has no verdict.

use thiserror::Error;

use crate::error::InvalidValue;
use crate::lti;
use crate::plant::PlantError;

/// What stops an analysis.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum StabilityError {
    /// A side cannot be built.
    #[error(transparent)]
    Plant(#[from] PlantError),
    /// A parameter is out of range.
    #[error(transparent)]
    Parameter(#[from] InvalidValue),
    /// Algebra that fails on the numbers it is given.
    #[error("the loop cannot be computed with: {0}")]
    Algebra(#[from] lti::Error),
    /// The response turns faster than can be followed.
    #[error(
        "the loop's response turns more often than can be followed in {evaluations} evaluations; shorten the delay"
    )]
    TooFast {
        /// How many were tried.
        evaluations: usize,
    },
    /// The one-tick matrix would be too large.
    #[error("the loop over {ticks} ticks of delay has {states} states, at most {most}; shorten the delay")]
    TooLarge {
        /// Ticks of delay, there and back.
        ticks: u64,
        /// How many states the matrix would have.
        states: u64,
        /// How many it may have.
        most: u64,
    },
    /// The solver of semidefinite programmes gives up.
    #[error("no certificate can be looked for: the solver says {status}")]
    Solver {
        /// What it says.
        status: String,
    },
}
