use trocar_document::{Block, Document, Section};

use super::Table;
use super::wrap::wrapped;

/// Indent of the second and later lines.
const INDENT: usize = 2;

/// A document as text: the answer, its limitations, and the sections for the terminal; with `all`, also those on
/// request.
pub fn document_text(document: &Document<'_>, all: bool) -> String {
    let answer = document.verdict.text();
    let head = if answer.is_empty() { document.title.clone() } else { format!("{}: {answer}", document.title) };
    let mut text = String::new();
    let mut paragraph = |line: &str| text.push_str(&wrapped(&format!("{line}\n"), INDENT));
    paragraph(&head);
    document.verdict.left_out.iter().for_each(|line| paragraph(line));
    for section in document.sections.iter().filter(|section| section.shown.is_on_terminal(all)) {
        text.push('\n');
        text.push_str(&section_text(section, all));
    }
    text
}

fn section_text(section: &Section, all: bool) -> String {
    let mut text = String::new();
    for block in &section.blocks {
        match block {
            Block::Text(line) => text.push_str(&wrapped(&format!("{line}\n"), INDENT)),
            Block::Command(line) => text.extend([line.as_str(), "\n"]),
            Block::Table(table) if table.shown.is_on_terminal(all) => {
                if !text.is_empty() {
                    text.push('\n');
                }
                match table.first_rows.filter(|(rows, _)| table.rows.len() > *rows) {
                    None => text.push_str(&Table::from(table).to_string()),
                    Some((rows, file)) => {
                        let first = trocar_document::Table { rows: table.rows[..rows].to_vec(), ..table.clone() };
                        text.push_str(&Table::from(&first).to_string());
                        text.push_str(&format!("… and {} more in {file}\n", table.rows.len() - rows));
                    }
                }
            }
            Block::Table(_) | Block::Figures { .. } => {}
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use trocar_document::{Shown, Verdict};

    #[test]
    fn the_terminal_shows_the_answer_first_and_further_sections_on_request() {
        let mut first = Section::new("a", "A");
        first.text("a line");
        let mut table = trocar_document::Table::new("t", "T", [("metric", "metric"), ("x", "x")]);
        table.row(["µ", "1 mm"]);
        first.table(table.clone());
        first.table(table.shown(Shown::InReports));
        let mut further = Section::new("b", "B").shown(Shown::WithAll);
        further.text("more");
        let document = Document {
            title: "name".into(),
            verdict: Verdict { sentences: vec!["stable".into()], left_out: vec!["not modelled: friction".into()] },
            sections: vec![first, further],
            ..Document::default()
        };
        let short = "name: stable\nnot modelled: friction\n\na line\n\nmetric     x\n────────────\nµ       1 mm\n";
        assert_eq!(document_text(&document, false), short);
        assert_eq!(document_text(&document, true), format!("{short}\nmore\n"));
    }

    #[test]
    fn a_long_table_has_its_first_rows_and_the_file_with_the_others() {
        let mut table = trocar_document::Table::new("t", "T", [("alarm", "alarm")]).first_rows(2, "events.csv");
        let mut section = |rows: usize| {
            table.rows.clear();
            (1..=rows).for_each(|row| table.row([row.to_string()]));
            let mut section = Section::new("a", "A");
            section.table(table.clone());
            section_text(&section, false)
        };
        assert!(section(4).ends_with("1\n2\n… and 2 more in events.csv\n"), "{}", section(4));
        assert!(section(2).ends_with("1\n2\n"), "{}", section(2));
    }
}
