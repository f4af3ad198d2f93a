//! A document as a page.

use super::compared::without_paths;
use super::page::{Block, Drawn, HtmlError, Page, Row, Section, warned};
use trocar_document::Figure;
use trocar_document::{Block as Part, Document, Shown, Table};

/// Number of intervals of a line.
const INTERVALS: usize = 1000;

/// A document with what its page needs besides.
pub struct DocumentPage<'a> {
    /// The document.
    pub document: &'a Document<'a>,
    /// The figures by name.
    pub figures: &'a [(&'static str, Figure<'static>)],
    /// The command that was given, without its flags.
    pub command: &'static str,
    /// The resolved scenario.
    pub toml: &'a str,
    /// The command that reproduces it.
    pub line: &'a str,
}

/// Returns the page of a document.
///
/// # Errors
/// [`HtmlError`].
pub fn document_html(page: &DocumentPage<'_>) -> Result<String, HtmlError> {
    let DocumentPage { document, command, .. } = page;
    let mut drawn = Drawn::default();
    for (name, figure) in page.figures {
        drawn.figures.insert(*name, vec![figure.for_page(INTERVALS)]);
    }
    let mut sections = vec![];
    for section in document.sections.iter().filter(|section| section.shown != Shown::OnTerminal) {
        let blocks = section.blocks.iter().filter_map(block).collect();
        sections.push(Section { id: section.id, title: section.title, blocks });
    }
    let file = Block::File { name: format!("{}.toml", document.title), text: without_paths(page.toml) };
    sections.push(Section { id: "scenario", title: "Scenario", blocks: vec![file] });
    let note = "Save the scenario above under its name, then run this command in the same folder.".to_owned();
    let commands = vec![Block::Command { line: page.line.to_owned(), note }];
    sections.push(Section { id: "again", title: "Reproduce", blocks: commands });
    let verdict = document.verdict.sentences.iter().chain(&document.verdict.left_out);
    Page {
        command,
        heading: document.title.clone(),
        lead: verdict.map(|line| sentence(line)).chain(warned(&document.warnings)).collect(),
        sections,
        drawn,
    }
    .render()
}

fn block(part: &Part) -> Option<Block> {
    match part {
        Part::Text(line) => Some(Block::text(sentence(line))),
        Part::Table(table) if table.shown == Shown::OnTerminal => None,
        Part::Table(table) => Some(table_block(table)),
        Part::Figure(name) => Some(Block::figures(name)),
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
