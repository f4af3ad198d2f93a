use std::path::PathBuf;

use clap::Args;

use super::error::Failure;
use super::figure::FigureArgs;
use super::terminal;
use trocar_document::Study as _;
use trocar_report::html::{Again, command_line, document_html};
use trocar_report::{Destination, document_text, write_document};
use trocar_studies::compare::PaperStudy;

const EXAMPLES: &str = "\
Examples:
  trocar paper
  trocar paper --out figures --figure-width 3.5in --figure-format pdf";

/// Reproduce the figures of the paper.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct PaperArgs {
    /// Folder for the files; it contains the folder paper with the figures and paper.html
    #[arg(long, value_name = "DIR", default_value = "out")]
    out: PathBuf,
    /// Print errors only
    #[arg(long, short)]
    quiet: bool,
    #[command(flatten)]
    figures: FigureArgs,
}

const PAGE: &str = "paper.html";

pub(super) fn run(args: &PaperArgs) -> Result<(), Failure> {
    let destination = Destination { figures: args.figures.style(), ..Destination::new(&args.out) };
    let folder = destination.open("paper", "paper")?;
    let study = PaperStudy::new()?;
    let document = study.document();
    write_document(&folder, &document)?;
    let again = Again {
        command: "trocar paper",
        files: vec![],
        line: command_line(["paper"]),
        note: "The page is written by this command.",
    };
    folder.write(PAGE, document_html(&document, &again)?.as_bytes())?;
    folder.commit()?;
    if !args.quiet {
        let (text, out) = (document_text(&document, false), folder.path.display());
        terminal::print(&format!("{text}figures: {out}/figure_NN; page: {out}/{PAGE}\n"))?;
    }
    Ok(())
}
