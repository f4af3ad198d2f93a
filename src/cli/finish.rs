//! The end of a command: the files, the report and the text of a document.

use super::error::CliError;
use super::figure::file_name;
use super::{OutputArgs, report, terminal};
use trocar_document::{Document, to_json};
use trocar_report::html::{Again, document_html};
use trocar_report::{Folder, document_text, wrapped, write_document};

/// How a command ends.
pub(super) struct Finish<'a> {
    /// The flags for output.
    pub(super) output: &'a OutputArgs,
    /// The folder of the files.
    pub(super) folder: Folder,
    /// Whether the terminal also shows what is shown on request.
    pub(super) all: bool,
    /// How a report says that the work is done again; without it there is no report.
    pub(super) report: Option<Again>,
}

impl Finish<'_> {
    /// Writes the files of a document.
    pub(super) fn write(&self, document: &Document<'_>) -> Result<(), CliError> {
        write_document(&self.folder, document)?;
        if let Some(again) = &self.report {
            self.folder.write(report::FILE, document_html(document, again)?.as_bytes())?;
        }
        Ok(())
    }

    /// Writes the files of a document, and prints its JSON or its text.
    pub(super) fn document(&self, document: &Document<'_>) -> Result<(), CliError> {
        self.write(document)?;
        if self.output.json { terminal::print(&to_json(&document.json)) } else { self.print(document) }
    }

    /// Prints the text of a document and where its files are, unless the command is quiet.
    pub(super) fn print(&self, document: &Document<'_>) -> Result<(), CliError> {
        let Self { output, folder, all, report } = self;
        if output.quiet {
            return Ok(());
        }
        terminal::draw(document.sketch.as_ref())?;
        let names = document.figures.iter().filter_map(|(name, _)| file_name(&folder.figures, name));
        let names: Vec<String> = names.collect();
        let figures =
            if names.is_empty() { String::new() } else { wrapped(&format!("figures: {}\n", names.join(", ")), 2) };
        let (text, files) = (document_text(document, *all), folder.path.display());
        terminal::print(&format!("{text}\n{figures}files: {files}\n"))?;
        if report.is_some() { report::print_path(folder) } else { Ok(()) }
    }
}
