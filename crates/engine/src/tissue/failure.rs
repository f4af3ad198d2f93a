//! A tissue that cannot go on.

use thiserror::Error;

/// Why a tissue cannot go on, as one that is computed by code of others.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("{message}")]
pub struct TissueFailure {
    message: Box<str>,
}

impl TissueFailure {
    /// A failure, described by a sentence.
    #[must_use]
    pub fn new(message: impl Into<Box<str>>) -> Self {
        Self { message: message.into() }
    }
}
