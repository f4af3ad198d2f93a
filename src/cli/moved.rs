//! Flags of `trocar compare` that other commands have taken over in 0.3. They are refused with the new command, in this release only.

use clap::Args;

use super::error::CliError;

/// The flags that are gone.
#[derive(Debug, Args)]
pub(super) struct MovedFlags {
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

impl MovedFlags {
    /// Refuses the flags.
    pub(super) fn check(&self) -> Result<(), CliError> {
        let moved = [
            (self.paper, "--paper", "trocar paper"),
            (self.schemes, "--schemes", "trocar strategies --schemes"),
            (self.persons.is_some(), "--persons", "trocar strategies --persons"),
            (self.patients.is_some(), "--patients", "trocar strategies --patients"),
            (self.strategies, "--strategies", "trocar strategies"),
        ];
        match moved.into_iter().find(|(is_given, ..)| *is_given) {
            Some((_, flag, now)) => Err(CliError::Moved { flag, now }),
            None => Ok(()),
        }
    }
}
