//! Why a sweep is not done.

use std::path::PathBuf;

use thiserror::Error;

use crate::run::RunError;
use crate::scenario::ScenarioError;

/// Why a sweep is not done.
#[derive(Debug, Error)]
pub enum SweepError {
    /// The sweep file or its scenario cannot be used as written.
    #[error(transparent)]
    File(#[from] ScenarioError),
    /// A case cannot be run.
    #[error("case {case} ({values}): {source}")]
    Case {
        /// Its number.
        case: u64,
        /// Its values.
        values: String,
        /// What is wrong.
        source: Box<RunError>,
    },
    /// What is there was begun with another sweep.
    #[error(
        "{folder} holds another sweep, or the same one before a change:\n{difference}give another --out, or remove that \
         folder",
        folder = folder.display()
    )]
    Changed {
        /// The folder.
        folder: PathBuf,
        /// Lines that differ, `-` there, `+` here.
        difference: String,
    },
    /// Another process runs the same part.
    #[error(
        "{path} is being written by another process; wait for it, or end it: the same command continues what it has done",
        path = path.display()
    )]
    Busy {
        /// The part's file.
        path: PathBuf,
    },
    /// Parts do not make a whole.
    #[error("{message}")]
    Parts {
        /// What is wrong, and what to do.
        message: String,
    },
    /// A file of the sweep cannot be read or written.
    #[error("{path}: {source}; what is done is kept, and the same command continues it", path = path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// Why not.
        source: std::io::Error,
    },
}

impl SweepError {
    /// Whether what the user gave is at fault.
    #[must_use]
    pub fn is_input(&self) -> bool {
        match self {
            Self::File(_) | Self::Changed { .. } | Self::Parts { .. } => true,
            Self::Case { source, .. } => matches!(**source, RunError::Scenario(_)),
            Self::Io { .. } | Self::Busy { .. } => false,
        }
    }
}
