//! The end of a command: files, report and text.

use super::error::Failure;
use super::{OutputArgs, figure, report, terminal};
use trocar_document::{Document, to_json};
use trocar_report::html::{Again, document_html};
use trocar_report::{Folder, document_text, write_document};

pub(super) struct Finish<'a> {
    pub(super) output: &'a OutputArgs,
    pub(super) folder: Folder,
    pub(super) all: bool,
    /// `None` if no report is requested.
    pub(super) report: Option<Again>,
}

impl Finish<'_> {
    pub(super) fn write(&self, document: &Document<'_>) -> Result<(), Failure> {
        write_document(&self.folder, document)?;
        if let Some(again) = &self.report {
            self.folder.write(report::FILE, document_html(document, again)?.as_bytes())?;
        }
        Ok(())
    }

    pub(super) fn document(&self, document: &Document<'_>) -> Result<(), Failure> {
        self.write(document)?;
        self.folder.commit()?;
        if self.output.json { terminal::print(&to_json(&document.json)) } else { self.print(document) }
    }

    pub(super) fn print(&self, document: &Document<'_>) -> Result<(), Failure> {
        let Self { output, folder, all, report } = self;
        if output.quiet {
            return Ok(());
        }
        terminal::draw(document.sketch.as_ref())?;
        let names = document.figures.iter().filter_map(|(name, _)| figure::file_name(&folder.figures, name));
        let names: Vec<String> = names.collect();
        let (text, figures) = (document_text(document, *all), figure::lines(&names));
        terminal::print(&format!("{text}\n{figures}files: {}\n", folder.path.display()))?;
        if report.is_some() { report::print_path(folder) } else { Ok(()) }
    }
}
