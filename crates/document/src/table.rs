//! Tables of typed cells.

use crate::Shown;
use crate::cell::Cell;

/// A column of a table.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Column {
    /// The key, which is stable from version to version.
    pub key: String,
    /// The heading.
    pub label: String,
}

/// A table. The first column names the rows.
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    /// The key, which is stable from version to version.
    pub key: &'static str,
    /// The caption.
    pub caption: String,
    /// The columns.
    pub columns: Vec<Column>,
    /// The rows. A row may have fewer cells than there are columns.
    pub rows: Vec<Row>,
    /// The surfaces that display the table.
    pub shown: Shown,
    /// True if all columns are texts, which are left-aligned.
    pub is_text: bool,
    /// Maximum number of rows on the terminal, and the file with all rows.
    pub first_rows: Option<(usize, &'static str)>,
}

/// A row of a table.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    /// The cells, the name of the row first.
    pub cells: Vec<Cell>,
    /// The meaning of the row in a sentence, for reports. Empty if the name is clear.
    pub meaning: &'static str,
}

impl Table {
    /// Shows only the first rows on the terminal, with the name of the file that has all.
    #[must_use]
    pub fn first_rows(self, rows: usize, file: &'static str) -> Self {
        Self { first_rows: Some((rows, file)), ..self }
    }

    /// Creates a table without rows. Columns are pairs of key and heading.
    #[must_use]
    pub fn new<K: Into<String>, L: Into<String>>(
        key: &'static str,
        caption: impl Into<String>,
        columns: impl IntoIterator<Item = (K, L)>,
    ) -> Self {
        let columns = columns.into_iter().map(|(key, label)| Column { key: key.into(), label: label.into() });
        Self {
            key,
            caption: caption.into(),
            columns: columns.collect(),
            rows: vec![],
            shown: Shown::Everywhere,
            is_text: false,
            first_rows: None,
        }
    }

    /// Left-aligns every column.
    #[must_use]
    pub fn of_text(self) -> Self {
        Self { is_text: true, ..self }
    }

    /// Sets the surfaces.
    #[must_use]
    pub fn shown(self, shown: Shown) -> Self {
        Self { shown, ..self }
    }

    /// Adds a row.
    pub fn row<C: Into<Cell>>(&mut self, cells: impl IntoIterator<Item = C>) {
        self.explained(cells, "");
    }

    /// Adds a row with its meaning.
    pub fn explained<C: Into<Cell>>(&mut self, cells: impl IntoIterator<Item = C>, meaning: &'static str) {
        self.rows.push(Row { cells: cells.into_iter().map(Into::into).collect(), meaning });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Number;

    #[test]
    fn rows_take_texts_and_numbers() {
        let mut table = Table::new("loop", "The loop", [("quantity", "loop"), ("value", "value")]);
        table.row(["a text", "another"]);
        table.explained([Cell::from("gain"), Number::si(2.0, "").into()], "A factor.");
        assert_eq!(table.rows[1].cells[1].value(), Some(2.0));
        assert_eq!(table.rows[1].meaning, "A factor.");
        assert_eq!(table.columns[0], Column { key: "quantity".into(), label: "loop".into() });
    }
}
