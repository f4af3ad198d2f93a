//! Why a run ends without a result.

use thiserror::Error;

use super::IntegrationError;
use crate::tissue::TissueFailure;

/// Why a run ends without a result.
#[derive(Debug, Error)]
pub enum EngineError {
    /// The numerical integration failed.
    #[error(transparent)]
    Integration(#[from] IntegrationError),
    /// The tissue cannot go on.
    #[error(transparent)]
    Tissue(#[from] TissueFailure),
    /// A part of the user's own returned a number that is not finite.
    #[error(transparent)]
    Part(#[from] InvalidPart),
}

/// A part of the user's own returned a number that is not finite.
#[derive(Debug, Clone, PartialEq, Error)]
#[error("the {roles} of your own returned a number that is not finite at {time_s} s (tick {tick})")]
pub struct InvalidPart {
    /// The role, or those of which one is the cause.
    pub roles: String,
    /// The tick.
    pub tick: u64,
    /// Its time in s.
    pub time_s: f64,
}
