use crate::Shown;
use crate::cell::Cell;

#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Column {
    /// Stable from version to version.
    pub key: String,
    pub label: String,
}

/// The first column names the rows.
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    /// Stable from version to version.
    pub key: &'static str,
    pub caption: String,
    pub columns: Vec<Column>,
    /// A row may have fewer cells than there are columns.
    pub rows: Vec<Row>,
    pub shown: Shown,
    /// Columns are texts, which are left-aligned.
    pub is_text: bool,
    /// Maximum number of rows on the terminal, and the file with all rows.
    pub first_rows: Option<(usize, &'static str)>,
}

#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    /// The name of the row first.
    pub cells: Vec<Cell>,
    /// In reports; empty if the name is clear.
    pub meaning: &'static str,
}

impl Table {
    /// The terminal shows only the first rows and the name of the file that has all.
    pub fn first_rows(self, rows: usize, file: &'static str) -> Self {
        Self { first_rows: Some((rows, file)), ..self }
    }

    /// Columns are pairs of key and heading.
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

    pub fn of_text(self) -> Self {
        Self { is_text: true, ..self }
    }

    pub fn shown(self, shown: Shown) -> Self {
        Self { shown, ..self }
    }

    pub fn row<C: Into<Cell>>(&mut self, cells: impl IntoIterator<Item = C>) {
        self.explained(cells, "");
    }

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
