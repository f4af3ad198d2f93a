//! What stops a command, and the exit code that says whose fault it was.

use std::process::ExitCode;

use thiserror::Error;

use crate::error::InvalidValue;
use crate::report::{OutputError, PictureError, diagnostic};
use crate::roc::RocError;
use crate::run::RunError;
use crate::scenario::ScenarioError;

/// Why a command ended early.
#[derive(Debug, Error)]
pub(super) enum CliError {
    /// A scenario cannot be run as written.
    #[error(transparent)]
    Scenario(#[from] ScenarioError),
    /// A setting is out of range.
    #[error(transparent)]
    Setting(#[from] InvalidValue),
    /// Two scenarios would write into the same folder.
    #[error("two scenarios are named {name:?} and would write into the same folder; give one another name")]
    SameName {
        /// The name.
        name: String,
    },
    /// What varies the made insertion was given beside other signals.
    #[error("--drop-n, --sharpness-s and --depth-m vary the made insertion; leave them or the other signals out")]
    OnlyMade,
    /// Ctrl-C was pressed.
    #[error("interrupted: {}", .kept.as_deref().unwrap_or("nothing was written"))]
    Interrupted {
        /// What there is all the same.
        kept: Option<String>,
    },
    /// A file is there already.
    #[error("{path} is there already; give another path, or --force to replace it")]
    Exists {
        /// The file.
        path: String,
    },
    /// Signals cannot be judged together.
    #[error(transparent)]
    Roc(RocError),
    /// The run failed.
    #[error(transparent)]
    Run(#[from] RunError),
    /// A file could not be written.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// A figure could not be made.
    #[error(transparent)]
    Picture(#[from] PictureError),
    /// Standard output could not be written.
    #[error("standard output cannot be written: {0}")]
    Print(std::io::Error),
}

impl From<RocError> for CliError {
    fn from(error: RocError) -> Self {
        match error {
            RocError::Scenario(error) => Self::Scenario(error),
            RocError::Setting(error) => Self::Setting(error),
            RocError::Run(error) => Self::Run(error),
            different @ RocError::DifferentDetectors { .. } => Self::Roc(different),
        }
    }
}

impl CliError {
    /// Says what is wrong on standard error; gives the exit code.
    pub(super) fn report(&self) -> ExitCode {
        match self {
            Self::Scenario(error) | Self::Run(RunError::Scenario(error)) => {
                anstream::eprintln!("{}", diagnostic::scenario_error(error));
            }
            other => anstream::eprintln!("error: {other}"),
        }
        match self {
            Self::Interrupted { .. } => ExitCode::from(super::interrupt::EXIT_CODE),
            Self::Scenario(_)
            | Self::Setting(_)
            | Self::OnlyMade
            | Self::SameName { .. }
            | Self::Roc(_)
            | Self::Exists { .. }
            | Self::Run(RunError::Scenario(_)) => ExitCode::from(2),
            Self::Run(RunError::Integration { .. }) | Self::Output(_) | Self::Picture(_) | Self::Print(_) => {
                ExitCode::FAILURE
            }
        }
    }
}
