//! Errors of commands, and their exit codes.

mod detect;
mod link;

use std::process::ExitCode;

pub(super) use detect::{DetectError, LabelProblem};
pub(super) use link::LinkError;
use thiserror::Error;

use crate::explore::ExploreError;
use trocar_core::error::InvalidValue;
use trocar_detect::calibration::CalibrationError;
use trocar_identify::IdentifyError;
use trocar_recording::RecordingError;
use trocar_report::html::HtmlError;
use trocar_report::{OutputError, PictureError};
use trocar_scenario::ScenarioError;
use trocar_stability::StabilityError;
use trocar_studies::compare::PaperError;
use trocar_studies::fmu::UnitError;
use trocar_studies::roc::RocError;
use trocar_studies::run::RunError;
use trocar_studies::stability_check::{CheckError, VerificationError};
use trocar_studies::sweep::SweepError;

#[derive(Debug, Error)]
pub(super) enum CliError {
    #[error(transparent)]
    Scenario(#[from] ScenarioError),
    #[error(transparent)]
    Setting(#[from] InvalidValue),
    #[error(
        "two scenarios have the name {name:?} and would write into the same folder: {}",
        same_name_remedy(first, second)
    )]
    SameName { name: String, first: String, second: String },
    #[error("--drop-n, --sharpness-s and --depth-m vary the synthetic insertion; remove them or the other signals")]
    OnlySynthetic,
    #[error("interrupted: {}", .kept.as_deref().unwrap_or("nothing was written"))]
    Interrupted { kept: Option<String> },
    #[error("{path} already exists; give another path, or --force to replace it")]
    Exists { path: String },
    #[error(transparent)]
    Detect(#[from] DetectError),
    #[error(transparent)]
    Calibration(#[from] CalibrationError),
    #[error(transparent)]
    Identify(#[from] IdentifyError),
    #[error("to identify the {machine}, {flag} is needed; give its column")]
    MissingColumn { flag: &'static str, machine: &'static str },
    #[error("{flag} is not used to identify the {machine}; remove it, or give another --machine")]
    UnusedColumn { flag: &'static str, machine: &'static str },
    #[error(transparent)]
    Roc(RocError),
    #[error(transparent)]
    Sweep(SweepError),
    /// A long sweep was started without `--yes`.
    #[error(
        "{cases} cases take about {about}; add --yes to start, use fewer points or seeds, or run parts with --shard"
    )]
    LongSweep { cases: u64, about: String },
    /// The folder contains the search of another design.
    #[error(
        "{folder} holds the search of another design, or of the same one before a change:\n{difference}give another --out, \
         or --overwrite to replace it"
    )]
    OtherDesign { folder: String, difference: String },
    #[error("the sweep has no case {case}: it has {cases} cases, numbered from 0")]
    NoCase { case: u64, cases: u64 },
    #[error("{axis}: {reason}")]
    Axis { axis: String, reason: String },
    #[error(transparent)]
    Response(RecordingError),
    #[error(transparent)]
    Stability(#[from] StabilityError),
    #[error("a certificate holds for one scenario; name it: trocar stability SCENARIO --verify {file}")]
    NoScenario { file: String },
    #[error("{path}: {source}")]
    Certificate { path: String, source: VerificationError },
    #[error("{path}: {source}")]
    Unreadable { path: String, source: std::io::Error },
    #[error(transparent)]
    Explore(#[from] ExploreError),
    #[error(transparent)]
    Run(#[from] RunError),
    #[error(transparent)]
    Output(#[from] OutputError),
    #[error(transparent)]
    Picture(#[from] PictureError),
    #[error(transparent)]
    Html(#[from] HtmlError),
    #[error("{count} {}, and --deny-warnings makes them errors", if *count == 1 { "warning" } else { "warnings" })]
    Warnings { count: usize },
    #[error("there is no warning, key or metric {:?}{}", trocar_base::names::shortened(word), nearest.as_ref().map_or(String::new(), |nearest| format!("; did you mean {nearest}?")))]
    Unknown {
        word: String,
        /// The most similar known word.
        nearest: Option<String>,
    },
    #[error(transparent)]
    Unit(UnitError),
    #[error(
        "{path}: {source}: run `cargo build --release`, which builds the library of units next to trocar, or give its \
         path with --library"
    )]
    NoLibrary { path: String, source: std::io::Error },
    #[error(transparent)]
    Link(#[from] LinkError),
    #[error("the unit cannot be packed: {0}")]
    Pack(std::io::Error),
    #[error("cannot write to standard output: {0}")]
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

impl From<UnitError> for CliError {
    fn from(error: UnitError) -> Self {
        match error {
            UnitError::Scenario(error) => Self::Scenario(error),
            other => Self::Unit(other),
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

fn same_name_remedy(first: &str, second: &str) -> String {
    if first == second {
        return format!("{first} is given twice; remove one");
    }
    format!("{first} and {second}; change the name in one of them, or run them separately, each with its own --out")
}

impl CliError {
    pub(super) fn report(&self) -> ExitCode {
        self.print(None);
        match self {
            Self::Interrupted { .. } => ExitCode::from(super::interrupt::EXIT_CODE),
            input if input.is_input() => ExitCode::from(2),
            _ => ExitCode::FAILURE,
        }
    }

    /// Adds the file if the message does not name it.
    pub(super) fn print(&self, file: Option<&str>) {
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
                anstream::eprintln!("{}", trocar_scenario::underlined(&error));
            }
            other => anstream::eprintln!("error: {}", named(other.to_string())),
        }
    }

    pub(super) fn is_input(&self) -> bool {
        match self {
            Self::Scenario(_)
            | Self::Setting(_)
            | Self::OnlySynthetic
            | Self::SameName { .. }
            | Self::Roc(_)
            | Self::Axis { .. }
            | Self::Response(_)
            | Self::Stability(
                StabilityError::Plant(_) | StabilityError::Parameter(_) | StabilityError::Measured { .. },
            )
            | Self::Certificate { source: VerificationError::Form(_), .. }
            | Self::Unreadable { .. }
            | Self::Exists { .. }
            | Self::NoCase { .. }
            | Self::NoScenario { .. }
            | Self::LongSweep { .. }
            | Self::OtherDesign { .. }
            | Self::Unknown { .. }
            | Self::Calibration(_)
            | Self::Identify(_)
            | Self::MissingColumn { .. }
            | Self::UnusedColumn { .. }
            | Self::Unit(_)
            | Self::NoLibrary { .. }
            | Self::Run(RunError::Scenario(_)) => true,
            Self::Detect(error) => error.is_input(),
            Self::Link(error) => error.is_input(),
            Self::Sweep(error) => error.is_input(),
            Self::Explore(error) => matches!(error, ExploreError::Bind { .. }),
            Self::Interrupted { .. }
            | Self::Warnings { .. }
            | Self::Stability(_)
            | Self::Certificate { .. }
            | Self::Run(RunError::Engine { .. })
            | Self::Output(_)
            | Self::Picture(_)
            | Self::Html(_)
            | Self::Pack(_)
            | Self::Print(_) => false,
        }
    }
}

impl From<PaperError> for CliError {
    fn from(error: PaperError) -> Self {
        match error {
            PaperError::Scenario(error) => error.into(),
            PaperError::Run(error) => error.into(),
        }
    }
}
