//! `trocar scenarios`.

use super::error::CliError;
use super::terminal;
use trocar_report::Table;
use trocar_sim::scenario::shipped_questions;

/// Prints the shipped scenarios, each with its question.
pub(super) fn run() -> Result<(), CliError> {
    let mut table = Table::new(["scenario", "question"]).flush_left();
    for (name, question) in shipped_questions() {
        table.row([format!("builtin:{name}"), question.to_owned()]);
    }
    terminal::print(&format!("{table}\nExample: trocar compare builtin:classical.toml builtin:augmented.toml\n"))
}
