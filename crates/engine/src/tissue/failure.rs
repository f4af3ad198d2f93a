//! Failure of a tissue.

use thiserror::Error;

/// The reason why a tissue cannot continue, for example an error of third-party code.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("{message}")]
pub struct TissueFailure {
    message: Box<str>,
}

impl TissueFailure {
    /// Creates a failure, described by a sentence.
    #[must_use]
    pub fn new(message: impl Into<Box<str>>) -> Self {
        Self { message: message.into() }
    }
}
