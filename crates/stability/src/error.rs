use thiserror::Error;

use trocar_core::error::InvalidValue;
use trocar_engine::plant::PlantError;
use trocar_lti as lti;

#[derive(Debug, Clone, PartialEq, Error)]
pub enum StabilityError {
    #[error(transparent)]
    Plant(#[from] PlantError),
    #[error(transparent)]
    Parameter(#[from] InvalidValue),
    #[error("the linear algebra of the loop failed: {0}")]
    Algebra(#[from] lti::Error),
    #[error("the phase of the loop's response cannot be tracked in {evaluations} evaluations; shorten the delay")]
    TooFast {
        /// Evaluated points.
        evaluations: usize,
    },
    #[error("the loop over {ticks} ticks of delay has {states} states, at most {max}; shorten the delay")]
    TooLarge {
        /// Round trip.
        ticks: u64,
        states: u64,
        max: u64,
    },
    #[error("the measured responses cannot be used: {reason}")]
    Measured {
        /// Includes a remedy.
        reason: &'static str,
    },
    #[error("the certificate does not cover a part of the augmentation")]
    UncoveredEvents,
    #[error("the search for a certificate failed: the solver reports {status}")]
    Solver {
        /// Reported by the solver.
        status: String,
    },
}
