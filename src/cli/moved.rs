//! Flags that were renamed or moved to another command in 0.3. This release refuses them and names the new flag.

use clap::Args;

use super::error::CliError;

/// The removed flags of `trocar compare`.
#[derive(Debug, Args)]
pub(super) struct MovedCompare {
    #[arg(long, hide = true)]
    paper: bool,
    #[arg(long, hide = true)]
    strategies: bool,
    #[arg(long, hide = true)]
    schemes: bool,
    #[arg(long, hide = true, value_name = "WHO")]
    persons: Option<String>,
    #[arg(long, hide = true, value_name = "N")]
    patients: Option<String>,
}

impl MovedCompare {
    pub(super) fn check(&self) -> Result<(), CliError> {
        let moved = [
            (self.paper, "--paper", "trocar paper"),
            (self.schemes, "--schemes", "trocar strategies --schemes"),
            (self.persons.is_some(), "--persons", "trocar strategies --persons"),
            (self.patients.is_some(), "--patients", "trocar strategies --patients"),
            (self.strategies, "--strategies", "trocar strategies"),
        ];
        match moved.into_iter().find(|(is_given, ..)| *is_given) {
            Some((_, flag, now)) => Err(CliError::Moved { command: "compare", flag, now }),
            None => Ok(()),
        }
    }
}

/// The former name of `--within-s` in `trocar detect`.
#[derive(Debug, Args)]
pub(super) struct MovedWindow {
    #[arg(long, hide = true, value_name = "S", allow_hyphen_values = true)]
    window_s: Option<String>,
}

impl MovedWindow {
    pub(super) fn check(&self) -> Result<(), CliError> {
        match self.window_s {
            Some(_) => Err(CliError::Moved { command: "detect", flag: "--window-s", now: "--within-s" }),
            None => Ok(()),
        }
    }
}
