//! The errors of a sweep.

use std::path::PathBuf;

use thiserror::Error;

use crate::run::RunError;
use trocar_scenario::ScenarioError;

/// The error of a sweep.
#[derive(Debug, Error)]
pub enum SweepError {
    /// The sweep file or its scenario is invalid.
    #[error(transparent)]
    File(#[from] ScenarioError),
    /// A case failed.
    #[error("case {case} ({values}): {source}")]
    Case {
        /// Number of the case.
        case: u64,
        /// Values of the case.
        values: String,
        /// Cause.
        source: Box<RunError>,
    },
    /// The folder belongs to another sweep.
    #[error(
        "{folder} holds another sweep, or the same one before a change:\n{difference}give another --out, or remove that \
         folder",
        folder = folder.display()
    )]
    Changed {
        /// The folder.
        folder: PathBuf,
        /// Different lines: `-` in the folder, `+` in this sweep.
        difference: String,
    },
    /// Another process computes the same part.
    #[error(
        "{path} is being written by another process; wait for it or end it, then the same command continues the sweep",
        path = path.display()
    )]
    Busy {
        /// File of the part.
        path: PathBuf,
    },
    /// The parts do not form a complete sweep.
    #[error("{message}")]
    Parts {
        /// Cause and remedy.
        message: String,
    },
    /// A file of the sweep cannot be read or written.
    #[error("{path}: {source}; complete cases are kept, and the same command continues the sweep", path = path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// Cause.
        source: std::io::Error,
    },
}

impl SweepError {
    /// True if the input is the cause.
    #[must_use]
    pub fn is_input(&self) -> bool {
        match self {
            Self::File(_) | Self::Changed { .. } | Self::Parts { .. } => true,
            Self::Case { source, .. } => matches!(**source, RunError::Scenario(_)),
            Self::Io { .. } | Self::Busy { .. } => false,
        }
    }
}
