//! Why a run ends without a result.

use thiserror::Error;

use super::IntegrationError;

/// The reason why a run ends without a result.
#[derive(Debug, Error)]
pub enum EngineError {
    /// The numerical integration failed.
    #[error(transparent)]
    Integration(#[from] IntegrationError),
    /// A user-defined part returned a number that is not finite.
    #[error(transparent)]
    Part(#[from] InvalidPart),
}

/// A user-defined part returned a number that is not finite.
#[derive(Debug, Clone, PartialEq, Error)]
#[error("the user-defined {roles} returned a number that is not finite at {time_s} s (tick {tick})")]
pub struct InvalidPart {
    /// The role of the part; several roles if any of them can be the cause.
    pub roles: String,
    /// Tick at which it happened.
    pub tick: u64,
    /// Time of the tick in s.
    pub time_s: f64,
}
