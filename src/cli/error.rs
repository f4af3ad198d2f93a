//! What stops a command, and the exit code that says whose fault it was.

mod detect;

use std::process::ExitCode;

pub(super) use detect::{DetectError, LabelProblem};
use thiserror::Error;

use crate::explore::ExploreError;
use trocar_report::html::HtmlError;
use trocar_report::{OutputError, PictureError, diagnostic};
use trocar_sim::detect::calibration::CalibrationError;
use trocar_sim::error::InvalidValue;
use trocar_sim::roc::RocError;
use trocar_sim::run::RunError;
use trocar_sim::scenario::ScenarioError;
use trocar_sim::stability::StabilityError;
use trocar_sim::stability_check::CheckError;
use trocar_sim::sweep::SweepError;

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
    #[error("two scenarios are named {name:?} and would write into the same folder: {}", two(first, second))]
    SameName {
        /// The name.
        name: String,
        /// The file of one, as it was given.
        first: String,
        /// That of the other.
        second: String,
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
    /// A detection cannot be done as asked, or not all of it.
    #[error(transparent)]
    Detect(#[from] DetectError),
    /// A recording cannot be calibrated on.
    #[error(transparent)]
    Calibration(#[from] CalibrationError),
    /// Signals cannot be judged together.
    #[error(transparent)]
    Roc(RocError),
    /// A sweep cannot be done as asked, or not all of it.
    #[error(transparent)]
    Sweep(SweepError),
    /// There is no such case.
    #[error("there is no case {case}: the sweep has {cases}, from 0 on")]
    NoCase {
        /// What was asked for.
        case: u64,
        /// How many there are.
        cases: u64,
    },
    /// An axis of a map that is none.
    #[error("{axis}: {reason}")]
    Axis {
        /// As it was given.
        axis: String,
        /// What is wrong with it.
        reason: String,
    },
    /// A loop cannot be analysed.
    #[error(transparent)]
    Stability(#[from] StabilityError),
    /// The page cannot be served.
    #[error(transparent)]
    Explore(#[from] ExploreError),
    /// The run failed.
    #[error(transparent)]
    Run(#[from] RunError),
    /// A file could not be written.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// A figure could not be made.
    #[error(transparent)]
    Picture(#[from] PictureError),
    /// A report could not be made.
    #[error(transparent)]
    Html(#[from] HtmlError),
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

impl From<SweepError> for CliError {
    fn from(error: SweepError) -> Self {
        match error {
            SweepError::File(error) => Self::Scenario(error),
            SweepError::Case { case, values, source } => match *source {
                RunError::Scenario(mut error) => {
                    error.message = format!("case {case} ({values}): {}", error.message);
                    Self::Scenario(error)
                }
                other => Self::Run(other),
            },
            other => Self::Sweep(other),
        }
    }
}

impl From<CheckError> for CliError {
    fn from(error: CheckError) -> Self {
        match error {
            CheckError::Stability(error) => Self::Stability(error),
            CheckError::Run(error) => Self::Run(error),
        }
    }
}

/// Two files in the way of each other, and the remedy.
fn two(first: &str, second: &str) -> String {
    if first == second {
        return format!("{first} is given twice; leave one out");
    }
    format!("{first} and {second}; write another name in one of them, or run them one by one, each with its own --out")
}

impl CliError {
    /// Says what is wrong on standard error; gives the exit code.
    pub(super) fn report(&self) -> ExitCode {
        self.show(None);
        match self {
            Self::Interrupted { .. } => ExitCode::from(super::interrupt::EXIT_CODE),
            input if input.is_input() => ExitCode::from(2),
            _ => ExitCode::FAILURE,
        }
    }

    /// Says what is wrong on standard error, and with which file if the message does not name it.
    pub(super) fn show(&self, file: Option<&str>) {
        let named = |message: String| match file {
            Some(file) if !message.contains(file) => format!("{file}: {message}"),
            _ => message,
        };
        match self {
            Self::Scenario(error) | Self::Run(RunError::Scenario(error)) => {
                let mut error = error.clone();
                if error.place.is_none() {
                    error.message = named(error.message);
                }
                anstream::eprintln!("{}", diagnostic::scenario_error(&error));
            }
            other => anstream::eprintln!("error: {}", named(other.to_string())),
        }
    }

    /// Whether what the user gave is at fault.
    pub(super) fn is_input(&self) -> bool {
        match self {
            Self::Scenario(_)
            | Self::Setting(_)
            | Self::OnlyMade
            | Self::SameName { .. }
            | Self::Roc(_)
            | Self::Axis { .. }
            | Self::Stability(StabilityError::Plant(_) | StabilityError::Parameter(_))
            | Self::Exists { .. }
            | Self::NoCase { .. }
            | Self::Calibration(_)
            | Self::Run(RunError::Scenario(_)) => true,
            Self::Detect(error) => error.is_input(),
            Self::Sweep(error) => error.is_input(),
            Self::Explore(error) => matches!(error, ExploreError::Bind { .. }),
            Self::Interrupted { .. }
            | Self::Stability(_)
            | Self::Run(RunError::Integration { .. })
            | Self::Output(_)
            | Self::Picture(_)
            | Self::Html(_)
            | Self::Print(_) => false,
        }
    }
}
