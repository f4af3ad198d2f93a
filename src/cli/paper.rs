//! `trocar paper`.

use std::path::PathBuf;

use clap::Args;

use super::error::CliError;
use super::figure::FigureArgs;
use super::terminal;
use trocar_report::{Folder, paper_figures, paper_text};
use trocar_studies::compare::PaperStudy;

const EXAMPLES: &str = "\
Examples:
  trocar paper
  trocar paper --out figures --figure-width 3.5in --figure-format pdf";

/// Reproduce the figures of the paper.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct PaperArgs {
    /// Folder for the figures and paper.html
    #[arg(long, value_name = "DIR", default_value = "out/paper")]
    out: PathBuf,
    /// Print errors only
    #[arg(long, short)]
    quiet: bool,
    #[command(flatten)]
    figures: FigureArgs,
}

pub(super) fn run(args: &PaperArgs) -> Result<(), CliError> {
    let study = PaperStudy::new()?;
    let folder = Folder::new(&args.out).with_figures(args.figures.style());
    paper_figures(&folder, &study)?;
    if !args.quiet {
        let out = args.out.display();
        terminal::print(&format!("{}figures: {out}/figure_NN; page: {out}/paper.html\n", paper_text(&study)))?;
    }
    Ok(())
}
