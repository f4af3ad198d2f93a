//! Aligned tables in Markdown.

use std::fmt::Write;

/// Maximum length of a line of text, in characters.
const WIDTH: usize = 120;

/// A table with names on the left and figures on the right.
pub struct Table {
    /// Number of name columns, from the left.
    names: usize,
    rows: Vec<Vec<String>>,
}

impl Table {
    /// Returns an empty table whose first `names` columns are names.
    pub fn new(names: usize, header: &[&str]) -> Self {
        Self { names, rows: vec![header.iter().map(|&cell| cell.to_owned()).collect()] }
    }

    /// Adds a row, which must be as wide as the header.
    pub fn row(&mut self, cells: impl IntoIterator<Item = String>) {
        self.rows.push(cells.into_iter().collect());
    }

    /// Returns a section: a heading, a description and the table.
    pub fn section(&self, heading: &str, about: &str) -> String {
        format!("## {heading}\n\n{}\n\n{}", wrapped(about), self.text())
    }

    pub fn text(&self) -> String {
        let columns = self.rows[0].len();
        let width = |j: usize| self.rows.iter().map(|row| row[j].chars().count()).max().unwrap_or(0).max(3);
        let widths: Vec<usize> = (0..columns).map(width).collect();
        let mut text = String::new();
        for (i, row) in self.rows.iter().enumerate() {
            for (j, (cell, &width)) in row.iter().zip(&widths).enumerate() {
                let _ =
                    if j < self.names { write!(text, "| {cell:<width$} ") } else { write!(text, "| {cell:>width$} ") };
            }
            text.push_str("|\n");
            if i == 0 {
                for (j, &width) in widths.iter().enumerate() {
                    let (line, end) = ("-".repeat(width + 1), if j < self.names { '-' } else { ':' });
                    let _ = write!(text, "|{line}{end}");
                }
                text.push_str("|\n");
            }
        }
        text
    }
}

/// Wraps a paragraph to lines of at most [`WIDTH`] characters.
fn wrapped(paragraph: &str) -> String {
    let mut lines: Vec<String> = vec![];
    for word in paragraph.split_whitespace() {
        match lines.last_mut() {
            Some(line) if line.chars().count() + 1 + word.chars().count() <= WIDTH => {
                line.push(' ');
                line.push_str(word);
            }
            _ => lines.push(word.to_owned()),
        }
    }
    lines.join("\n")
}

/// Formats a figure with three digits, or as an integer if it has more.
pub fn figure(value: f64) -> String {
    let decimals = match value.abs() {
        size if size >= 99.95 => 0,
        size if size >= 9.995 => 1,
        size if size >= 0.9995 || size == 0.0 => 2,
        _ => 3,
    };
    format!("{value:.decimals$}")
}

/// Formats a fraction in per cent.
pub fn percent(share: f64) -> String {
    format!("{:.1} %", 100.0 * share)
}
