use thiserror::Error;

use super::IntegrationError;

#[derive(Debug, Error)]
pub enum EngineError {
    #[error(transparent)]
    Integration(#[from] IntegrationError),
    #[error(transparent)]
    Part(#[from] InvalidPart),
}

#[derive(Debug, Clone, PartialEq, Error)]
#[error("the user-defined {roles} returned a number that is not finite at {time_s} s (tick {tick})")]
pub struct InvalidPart {
    pub roles: String,
    pub tick: u64,
    pub time_s: f64,
}
