use std::path::PathBuf;

use thiserror::Error;

use crate::run::RunError;
use trocar_scenario::ScenarioError;

#[derive(Debug, Error)]
pub enum SweepError {
    #[error(transparent)]
    File(#[from] ScenarioError),
    #[error("case {case} ({values}): {source}")]
    Case {
        case: u64,
        /// Values of the axes.
        values: String,
        source: Box<RunError>,
    },
    #[error(
        "{folder} holds another sweep, or the same one before a change:\n{difference}give another --out, or remove that \
         folder",
        folder = folder.display()
    )]
    Changed {
        folder: PathBuf,
        /// Different lines: `-` in the folder, `+` in this sweep.
        difference: String,
    },
    #[error(
        "{path} is being written by another process; wait for it or end it, then the same command continues the sweep",
        path = path.display()
    )]
    Busy {
        /// File of the part that another process computes.
        path: PathBuf,
    },
    #[error("{message}")]
    Parts {
        /// Cause and remedy.
        message: String,
    },
    #[error("{path}: {source}; complete cases are kept, and the same command continues the sweep", path = path.display())]
    Io {
        /// File that cannot be read or written.
        path: PathBuf,
        source: std::io::Error,
    },
}
