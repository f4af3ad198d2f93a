//! `trocar completions` and `trocar man`.

use clap::{Args, CommandFactory};
use clap_complete::Shell;

use super::error::CliError;
use super::{Cli, terminal};
use trocar_report::Folder;

/// Print completions for a shell.
#[derive(Debug, Args)]
pub(super) struct CompletionsArgs {
    /// The shell
    shell: Shell,
}

/// Write the manual pages.
#[derive(Debug, Args)]
pub(super) struct ManArgs {
    /// Folder for the pages of all commands; without it, the page of trocar is printed
    #[arg(long, value_name = "DIR")]
    out: Option<std::path::PathBuf>,
}

pub(super) fn completions(args: &CompletionsArgs) -> Result<(), CliError> {
    let mut script = vec![];
    clap_complete::generate(args.shell, &mut Cli::command(), "trocar", &mut script);
    terminal::print(&String::from_utf8_lossy(&script))
}

pub(super) fn man(args: &ManArgs) -> Result<(), CliError> {
    let mut command = Cli::command();
    command.build();
    let Some(out) = &args.out else { return terminal::print(&page(command)?) };
    let folder = Folder::new(out);
    for inner in command.get_subcommands().filter(|inner| inner.get_name() != "help") {
        folder.write(&format!("trocar-{}.1", inner.get_name()), page(inner.clone())?.as_bytes())?;
    }
    folder.write("trocar.1", page(command)?.as_bytes())?;
    terminal::print(&format!("manual pages: {}\n", out.display()))
}

fn page(command: clap::Command) -> Result<String, CliError> {
    let mut text = vec![];
    clap_mangen::Man::new(command).render(&mut text).map_err(CliError::Print)?;
    Ok(String::from_utf8_lossy(&text).into_owned())
}
