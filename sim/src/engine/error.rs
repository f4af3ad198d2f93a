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
}
