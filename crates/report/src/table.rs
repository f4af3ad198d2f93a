use std::fmt;

use crate::wrap::{WIDTH, lines, longest_part};

const GAP: &str = "  ";

/// Minimum width of a column with broken cells, at which words are cut.
const MIN_BROKEN: usize = 16;
const MAX_BROKEN: usize = 36;

/// A table with a heading. The first column is left-aligned, the others are right-aligned.
#[derive(Debug, Clone, Default)]
pub struct Table {
    rows: Vec<Vec<String>>,
    flush_left: bool,
}

impl From<&trocar_document::Table> for Table {
    fn from(table: &trocar_document::Table) -> Self {
        let mut text = Self::new(table.columns.iter().map(|column| column.label.as_str()));
        for row in &table.rows {
            text.row(row.cells.iter().map(ToString::to_string));
        }
        Self { flush_left: table.is_text, ..text }
    }
}

impl Table {
    fn new<S: Into<String>>(heading: impl IntoIterator<Item = S>) -> Self {
        Self { rows: vec![heading.into_iter().map(Into::into).collect()], flush_left: false }
    }

    fn row<S: Into<String>>(&mut self, cells: impl IntoIterator<Item = S>) {
        self.rows.push(cells.into_iter().map(Into::into).collect());
    }
}

#[derive(Clone, Copy)]
enum Broken {
    Nothing,
    Headings,
    Texts,
    Everything,
}

impl fmt::Display for Table {
    /// Writes the table with lines of at most [`WIDTH`] characters. If necessary it breaks headings, then the cells of
    /// text columns, then prints the columns in several blocks, each with the first column.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let columns = self.rows.iter().map(Vec::len).max().unwrap_or(0);
        let mut block = vec![0];
        for column in 1..columns {
            block.push(column);
            if block.len() > 2 && self.widths(&block).is_none() {
                block.pop();
                self.write_block(f, &block)?;
                writeln!(f)?;
                block = vec![0, column];
            }
        }
        self.write_block(f, &block)
    }
}

impl Table {
    fn is_text(&self, column: usize) -> bool {
        column == 0 || self.flush_left
    }

    fn width(&self, column: usize, broken: Broken) -> usize {
        let whole = |cell: &str| cell.chars().count();
        let part = |cell: &str| longest_part(cell).clamp(MIN_BROKEN.min(whole(cell)), MAX_BROKEN);
        let of = |(row, cells): (usize, &Vec<String>)| {
            let cell = cells.get(column).map_or("", String::as_str);
            match broken {
                Broken::Nothing => whole(cell),
                Broken::Headings | Broken::Texts if row == 0 && column > 0 => longest_part(cell).min(MAX_BROKEN),
                Broken::Headings if row == 0 => part(cell),
                Broken::Texts if self.is_text(column) => part(cell),
                Broken::Headings | Broken::Texts => whole(cell),
                Broken::Everything => part(cell),
            }
        };
        self.rows.iter().enumerate().map(of).max().unwrap_or(0)
    }

    fn widths(&self, columns: &[usize]) -> Option<Vec<usize>> {
        let of = |broken: Broken| columns.iter().map(|column| self.width(*column, broken)).collect::<Vec<_>>();
        let room = WIDTH.saturating_sub(GAP.len() * (columns.len() - 1));
        let mut widths = of(Broken::Nothing);
        let steps: &[Broken] = match columns.len() {
            0..=2 => &[Broken::Headings, Broken::Texts, Broken::Everything],
            3.. => &[Broken::Headings, Broken::Texts],
        };
        for step in steps {
            let least = of(*step);
            while widths.iter().sum::<usize>() > room {
                let can_shrink = (0..widths.len()).filter(|index| widths[*index] > least[*index]);
                let Some(widest) = can_shrink.max_by_key(|index| widths[*index]) else { break };
                widths[widest] -= 1;
            }
        }
        (widths.iter().sum::<usize>() <= room).then_some(widths)
    }

    fn write_block(&self, f: &mut fmt::Formatter<'_>, columns: &[usize]) -> fmt::Result {
        let widths = self.widths(columns).unwrap_or_else(|| vec![MAX_BROKEN; columns.len()]);
        for (index, row) in self.rows.iter().enumerate() {
            let is_heading = index == 0;
            let cell = |(column, width): (&usize, &usize)| {
                let indent = if *column == 0 && !is_heading { 2 } else { 0 };
                lines(row.get(*column).map_or("", String::as_str), *width, indent)
            };
            let cells: Vec<Vec<String>> = columns.iter().zip(&widths).map(cell).collect();
            let height = cells.iter().map(Vec::len).max().unwrap_or(0);
            for at in 0..height {
                let mut line = String::new();
                for ((column, cell), width) in columns.iter().zip(&cells).zip(&widths) {
                    // Headings are aligned at the bottom.
                    let above = if is_heading { height - cell.len() } else { 0 };
                    let text = at.checked_sub(above).and_then(|at| cell.get(at)).map_or("", String::as_str);
                    let padding = " ".repeat(width.saturating_sub(text.chars().count()));
                    if *column > 0 {
                        line.push_str(GAP);
                    }
                    let (left, right) = if self.is_text(*column) { (text, &*padding) } else { (&*padding, text) };
                    line.push_str(left);
                    line.push_str(right);
                }
                writeln!(f, "{}", line.trim_end())?;
            }
            if is_heading {
                let total: usize = widths.iter().sum::<usize>() + GAP.len() * (columns.len() - 1);
                writeln!(f, "{}", "─".repeat(total))?;
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_aligned() {
        let mut table = Table::new(["metric", "a"]);
        table.row(["µ", "10 mm"]);
        table.row(["longer name", "—"]);
        let expected = "metric           a\n──────────────────\nµ            10 mm\nlonger name      —\n";
        assert_eq!(table.to_string(), expected);
    }

    #[test]
    fn a_wide_table_breaks_headings_then_texts_then_into_blocks() {
        let fits = |table: &Table| table.to_string().lines().all(|line| line.chars().count() <= WIDTH);
        let mut table = Table::new(["metric", "a-scenario-with-a-very-long-name", "another-scenario-with-a-long-name"]);
        table.row(["in noise: false samples, derivative at best", "33", "0"]);
        let text = table.to_string();
        assert!(fits(&table) && text.contains("at best"), "{text}");
        assert!(text.contains("long-name\n─"), "{text}");
        let mut table = Table::new((0..12).map(|column| format!("column {column}")));
        table.row((0..12).map(|column| format!("{column}.00 [0.000, 9.999] mm")));
        let text = table.to_string();
        assert!(fits(&table), "{text}");
        assert_eq!(text.matches("─\n").count(), 6, "{text}");
        assert_eq!(text.matches("0.00 [0.000, 9.999] mm").count(), 6 + 1, "{text}");
        let mut table = Table::new(["a".repeat(200), "b".repeat(200)]);
        table.row(["word ".repeat(50), "word ".repeat(50)]);
        assert!(fits(&table), "{table}");
    }
}
