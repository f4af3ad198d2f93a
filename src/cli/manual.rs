use std::path::Path;

use clap::{Args, CommandFactory};

use super::error::Failure;
use super::{Cli, terminal};
use trocar_report::write_file;

const EXAMPLES: &str = "\
Examples:
  trocar man | man -l -
  trocar man --out ~/.local/share/man/man1";

/// Write the manual pages.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct ManArgs {
    /// Folder for the pages of all commands; without it, print the page of trocar
    #[arg(long, value_name = "DIR")]
    out: Option<std::path::PathBuf>,
}

pub(super) fn run(args: &ManArgs) -> Result<(), Failure> {
    let mut command = Cli::command();
    command.build();
    let Some(out) = &args.out else { return terminal::print(&page(command)?) };
    write_pages(out, "trocar", command)?;
    terminal::print(&format!("manual pages: {}\n", out.display()))
}

fn write_pages(folder: &Path, name: &str, command: clap::Command) -> Result<(), Failure> {
    for inner in command.get_subcommands().filter(|inner| inner.get_name() != "help") {
        write_pages(folder, &format!("{name}-{}", inner.get_name()), inner.clone())?;
    }
    Ok(write_file(&folder.join(format!("{name}.1")), page(command)?.as_bytes())?)
}

fn page(command: clap::Command) -> Result<String, Failure> {
    let mut text = vec![];
    clap_mangen::Man::new(command).render(&mut text).map_err(terminal::failed)?;
    Ok(String::from_utf8_lossy(&text).into_owned())
}
