use std::path::PathBuf;

use clap::Args;

use super::error::Failure;
use super::terminal;
use trocar_report::write_file;
use trocar_scenario::Starter;

const EXAMPLES: &str = "\
Examples:
  trocar init my.toml && trocar run my.toml
  trocar init mine.toml --replay    a replay; replace the recording by yours";

/// Write a commented starter scenario.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct InitArgs {
    /// File to write
    #[arg(value_name = "FILE", default_value = "scenario.toml")]
    file: PathBuf,
    #[command(flatten)]
    kind: KindArgs,
    /// Replace an existing file
    #[arg(long)]
    force: bool,
}

#[derive(Debug, Args)]
#[group(multiple = false)]
struct KindArgs {
    /// An insertion through layers of tissue, each with its own thickness and rupture force [default]
    #[arg(long)]
    layers: bool,
    /// A replay of a recording: the file, its columns, units and signs
    #[arg(long)]
    replay: bool,
    /// The shipped augmented insertion with a few changes
    #[arg(long)]
    minimal: bool,
    /// Every key with its default, commented out
    #[arg(long)]
    all: bool,
}

impl KindArgs {
    fn starter(&self) -> Starter {
        match self {
            Self { replay: true, .. } => Starter::Replay,
            Self { minimal: true, .. } => Starter::Minimal,
            Self { all: true, .. } => Starter::All,
            Self { replay: false, minimal: false, all: false, layers: _ } => Starter::Tissue,
        }
    }
}

pub(super) fn run(args: &InitArgs) -> Result<(), Failure> {
    super::refuse_existing(&args.file, args.force)?;
    let name = args.file.file_stem().unwrap_or_default().to_string_lossy();
    let starter = args.kind.starter();
    write_file(&args.file, starter.text(&name).as_bytes())?;
    let subject = match starter {
        Starter::Tissue => "an insertion through layers of tissue",
        Starter::Replay => "a replay of a recording",
        Starter::Minimal => "the shipped augmented insertion with a few changes",
        Starter::All => "every key with its default",
    };
    let file = args.file.display();
    terminal::print(&format!("{file}: {subject}; next: trocar run {file}\n"))
}
