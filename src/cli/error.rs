//! Errors of commands, and their exit codes.

use std::error::Error;
use std::fmt;
use std::process::ExitCode;

use crate::explore::ExploreError;
use trocar_core::error::InvalidValue;
use trocar_detect::calibration::CalibrationError;
use trocar_identify::IdentifyError;
use trocar_link::RemoteLogError;
use trocar_recording::RecordingError;
use trocar_report::html::HtmlError;
use trocar_report::{OutputError, PictureError};
use trocar_scenario::ScenarioError;
use trocar_stability::StabilityError;
use trocar_studies::fmu::UnitError;
use trocar_studies::roc::RocError;
use trocar_studies::run::RunError;
use trocar_studies::stability_check::CheckError;
use trocar_studies::sweep::SweepError;

/// Selects the exit code.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    /// The user can correct the input.
    Input,
    Work,
    Interrupted,
}

/// The reason why a command ends early.
#[derive(Debug)]
pub(super) struct Failure {
    pub(super) kind: Kind,
    /// A text or the error of a library. A [`ScenarioError`] is printed with its underlined lines.
    pub(super) error: Box<dyn Error + Send + Sync>,
}

impl Failure {
    pub(super) fn input(error: impl Into<Box<dyn Error + Send + Sync>>) -> Self {
        Self { kind: Kind::Input, error: error.into() }
    }

    pub(super) fn work(error: impl Into<Box<dyn Error + Send + Sync>>) -> Self {
        Self { kind: Kind::Work, error: error.into() }
    }

    /// `kept` names the results that are kept.
    pub(super) fn interrupted(kept: &str) -> Self {
        Self { kind: Kind::Interrupted, error: format!("interrupted: {kept}").into() }
    }

    pub(super) fn report(&self) -> ExitCode {
        self.print(None);
        match self.kind {
            Kind::Input => ExitCode::from(2),
            Kind::Work => ExitCode::FAILURE,
            Kind::Interrupted => ExitCode::from(super::interrupt::EXIT_CODE),
        }
    }

    /// Adds the file if the message does not name it.
    pub(super) fn print(&self, file: Option<&str>) {
        let named = |message: String| match file {
            Some(file) if !message.contains(file) => format!("{file}: {message}"),
            _ => message,
        };
        if let Some(error) = self.scenario() {
            let mut error = error.clone();
            if error.place.is_none() {
                error.message = named(error.message);
            }
            anstream::eprintln!("{}", trocar_scenario::underlined(&error));
        } else {
            anstream::eprintln!("error: {}", named(self.to_string()));
        }
    }

    pub(super) fn scenario(&self) -> Option<&ScenarioError> {
        self.error.downcast_ref()
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.error.fmt(f)
    }
}

impl From<ScenarioError> for Failure {
    fn from(error: ScenarioError) -> Self {
        Self::input(error)
    }
}

impl From<InvalidValue> for Failure {
    fn from(error: InvalidValue) -> Self {
        Self::input(error)
    }
}

impl From<RecordingError> for Failure {
    fn from(error: RecordingError) -> Self {
        Self::input(error)
    }
}

impl From<CalibrationError> for Failure {
    fn from(error: CalibrationError) -> Self {
        Self::input(error)
    }
}

impl From<IdentifyError> for Failure {
    fn from(error: IdentifyError) -> Self {
        Self::input(error)
    }
}

impl From<RemoteLogError> for Failure {
    fn from(error: RemoteLogError) -> Self {
        Self::input(error)
    }
}

impl From<OutputError> for Failure {
    fn from(error: OutputError) -> Self {
        Self::work(error)
    }
}

impl From<HtmlError> for Failure {
    fn from(error: HtmlError) -> Self {
        Self::work(error)
    }
}

impl From<PictureError> for Failure {
    fn from(error: PictureError) -> Self {
        match error {
            PictureError::Write(error) => error.into(),
            PictureError::Draw(error) => Self::work(error),
        }
    }
}

impl From<RunError> for Failure {
    fn from(error: RunError) -> Self {
        match error {
            RunError::Scenario(error) => error.into(),
            RunError::Engine { .. } => Self::work(error),
        }
    }
}

impl From<RocError> for Failure {
    fn from(error: RocError) -> Self {
        match error {
            RocError::Scenario(error) => error.into(),
            RocError::Run(error) => error.into(),
            RocError::Setting(_) | RocError::DifferentDetectors { .. } => Self::input(error),
        }
    }
}

impl From<SweepError> for Failure {
    fn from(error: SweepError) -> Self {
        match error {
            SweepError::File(error) => error.into(),
            SweepError::Case { case, values, source } => match *source {
                RunError::Scenario(mut error) => {
                    error.message = format!("case {case} ({values}): {}", error.message);
                    error.into()
                }
                other => other.into(),
            },
            SweepError::Changed { .. } | SweepError::Parts { .. } => Self::input(error),
            SweepError::Io { .. } | SweepError::Busy { .. } => Self::work(error),
        }
    }
}

impl From<UnitError> for Failure {
    fn from(error: UnitError) -> Self {
        match error {
            UnitError::Scenario(error) => error.into(),
            other => Self::input(other),
        }
    }
}

impl From<StabilityError> for Failure {
    fn from(error: StabilityError) -> Self {
        match error {
            StabilityError::Plant(_) | StabilityError::Parameter(_) | StabilityError::Measured { .. } => {
                Self::input(error)
            }
            StabilityError::Algebra(_)
            | StabilityError::TooFast { .. }
            | StabilityError::TooLarge { .. }
            | StabilityError::UncoveredEvents
            | StabilityError::Solver { .. } => Self::work(error),
        }
    }
}

impl From<CheckError> for Failure {
    fn from(error: CheckError) -> Self {
        match error {
            CheckError::Stability(error) => error.into(),
            CheckError::Run(error) => error.into(),
        }
    }
}

impl From<ExploreError> for Failure {
    fn from(error: ExploreError) -> Self {
        match error {
            ExploreError::Bind { .. } => Self::input(error),
            ExploreError::System(_) => Self::work(error),
        }
    }
}
