use super::page::{Block, Drawn, HtmlError, Page, Row, Section, Window, warned};
use serde_json::Value as Json;
use trocar_document::{Block as Part, Document, Shown, Table};

const INTERVALS: usize = 1000;

pub struct Again {
    /// The original command without its flags.
    pub command: &'static str,
    /// The names and contents of the required files.
    pub files: Vec<(String, String)>,
    /// The steps before the command.
    pub note: &'static str,
    pub line: String,
}

impl Again {
    /// The step before a command that reads the files of the page.
    pub const SAVE: &'static str =
        "Save the files above under their names, with their recordings, then run this command in the same folder.";
}

/// Renders the page of a document.
pub fn document_html(document: &Document<'_>, again: &Again) -> Result<String, HtmlError> {
    let mut drawn = Drawn { animation: document.animation.clone(), ..Drawn::default() };
    let mut sections = vec![];
    for section in document.sections.iter().filter(|section| section.shown != Shown::OnTerminal) {
        let blocks = section.blocks.iter().filter_map(|part| block(part, document, &mut drawn)).collect();
        sections.push(Section { id: section.id.clone(), title: section.title.clone(), blocks });
    }
    let file = |(name, text): &(String, String)| Block::File { name: name.clone(), text: without_paths(text) };
    let title = if again.files.len() == 1 { "Scenario" } else { "Scenarios" };
    if !again.files.is_empty() {
        let blocks = again.files.iter().map(file).collect();
        sections.push(Section { id: "scenario".into(), title: title.into(), blocks });
    }
    let commands = vec![Block::Command { line: again.line.clone(), note: again.note.to_owned() }];
    sections.push(Section { id: "again".into(), title: "Reproduce".into(), blocks: commands });
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

fn sentence(line: &str) -> String {
    let line = line.trim();
    let mut letters = line.chars();
    let first: String = letters.next().into_iter().flat_map(char::to_uppercase).collect();
    format!("{first}{}{}", letters.as_str(), if line.ends_with('.') { "" } else { "." })
}

/// A resolved scenario without local paths.
pub(super) fn without_paths(toml: &str) -> String {
    let line = |line: &str| {
        let file = ["file", "delays_file"].into_iter().find_map(|key| {
            let value = line.strip_prefix(key)?.strip_prefix(" = ")?;
            let value: toml::Value = toml::from_str::<toml::Table>(&format!("v = {value}")).ok()?.remove("v")?;
            let path = std::path::Path::new(value.as_str()?);
            let name = path.file_name().filter(|_| path.is_absolute())?;
            Some(format!("{key} = {}", toml::Value::String(name.to_string_lossy().into_owned())))
        });
        format!("{}\n", file.as_deref().unwrap_or(line))
    };
    toml.lines().map(line).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_lose_their_folders_and_nothing_else_changes() {
        let toml = "name = \"a\"\n\n[recording]\nfile = \"/home/someone/a b.csv\"\nfile_sign = 1.0\n";
        assert_eq!(without_paths(toml), toml.replace("/home/someone/", ""));
        let shipped = "file = \"builtin:own.csv\"\n";
        assert_eq!(without_paths(shipped), shipped);
    }
}
