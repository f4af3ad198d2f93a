//! A document as a page.

use super::compared::without_paths;
use super::page::{Block, Drawn, HtmlError, Page, Row, Section, Window, warned};
use serde_json::Value as Json;
use trocar_document::{Block as Part, Document, Shown, Table};

/// Number of intervals of a line.
const INTERVALS: usize = 1000;

/// How the work of a page is done again.
pub struct Again {
    /// The command that was given, without its flags.
    pub command: &'static str,
    /// The names and contents of the files that it needs.
    pub files: Vec<(String, String)>,
    /// The command that reproduces the page.
    pub line: String,
    /// What to do before.
    pub note: &'static str,
}

impl Again {
    /// The note of a command that needs nothing but the files.
    pub const SAVE: &str = "Save the files above under their names, then run this command in the same folder.";
}

/// Returns the page of a document.
///
/// # Errors
/// [`HtmlError`].
pub fn document_html(document: &Document<'_>, again: &Again) -> Result<String, HtmlError> {
    let mut drawn = Drawn::default();
    let mut sections = vec![];
    for section in document.sections.iter().filter(|section| section.shown != Shown::OnTerminal) {
        let blocks = section.blocks.iter().filter_map(|part| block(part, document, &mut drawn)).collect();
        sections.push(Section { id: section.id, title: section.title, blocks });
    }
    let file = |(name, text): &(String, String)| Block::File { name: name.clone(), text: without_paths(text) };
    let title = if again.files.len() == 1 { "Scenario" } else { "Scenarios" };
    if !again.files.is_empty() {
        sections.push(Section { id: "scenario", title, blocks: again.files.iter().map(file).collect() });
    }
    let commands = vec![Block::Command { line: again.line.clone(), note: again.note.to_owned() }];
    sections.push(Section { id: "again", title: "Reproduce", blocks: commands });
    let verdict = document.verdict.sentences.iter().chain(&document.verdict.left_out);
    Page {
        command: again.command,
        heading: document.title.clone(),
        lead: verdict.map(|line| sentence(line)).chain(warned(&document.warnings)).collect(),
        sections,
        drawn,
    }
    .render()
}

/// Returns a part as a block, and keeps its figures.
fn block(part: &Part, document: &Document<'_>, drawn: &mut Drawn) -> Option<Block> {
    match part {
        Part::Text(line) => Some(Block::text(sentence(line))),
        Part::Command(line) => Some(Block::Command { line: line.clone(), note: String::new() }),
        Part::Table(table) if table.shown == Shown::OnTerminal => None,
        Part::Table(table) => Some(table_block(table)),
        Part::Figures { names, windows } => {
            let name = names.first()?.clone();
            let figures = names.iter().filter_map(|name| document.figures.iter().find(|(other, _)| other == name));
            let figures: Vec<Json> = figures.map(|(_, figure)| figure.for_page(INTERVALS)).collect();
            drawn.figures.insert(name.clone(), figures);
            let window = |window: &trocar_document::Window| Window {
                label: window.label.clone(),
                from: window.range.0,
                to: window.range.1,
            };
            Some(Block::Figures { name, windows: windows.iter().map(window).collect() })
        }
    }
}

fn table_block(table: &Table) -> Block {
    let row = |row: &trocar_document::Row| Row {
        cells: row.cells.iter().map(ToString::to_string).collect(),
        meaning: row.meaning,
    };
    Block::Table {
        caption: table.caption.clone(),
        head: table.columns.iter().map(|column| column.label.clone()).collect(),
        rows: table.rows.iter().map(row).collect(),
        is_text: table.is_text,
    }
}

/// Returns a line as a sentence.
fn sentence(line: &str) -> String {
    let line = line.trim();
    let mut letters = line.chars();
    let first: String = letters.next().into_iter().flat_map(char::to_uppercase).collect();
    format!("{first}{}{}", letters.as_str(), if line.ends_with('.') { "" } else { "." })
}
