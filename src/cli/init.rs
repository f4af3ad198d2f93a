//! `trocar init`.

use std::path::PathBuf;

use clap::Args;

use super::error::CliError;
use super::terminal;
use trocar_report::write_file;
use trocar_sim::scenario::starter;

const EXAMPLES: &str = "\
Example:
  trocar init my.toml && trocar run my.toml";

/// Write a commented starter scenario.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct InitArgs {
    /// File to write
    #[arg(value_name = "FILE", default_value = "scenario.toml")]
    file: PathBuf,
    /// Replace an existing file
    #[arg(long)]
    force: bool,
}

pub(super) fn run(args: &InitArgs) -> Result<(), CliError> {
    if args.file.exists() && !args.force {
        return Err(CliError::Exists { path: args.file.display().to_string() });
    }
    let name = args.file.file_stem().unwrap_or_default().to_string_lossy();
    write_file(&args.file, starter(&name).as_bytes())?;
    let file = args.file.display();
    terminal::print(&format!("{file}: every key with its default; next: trocar run {file}\n"))
}
