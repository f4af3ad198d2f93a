//! The files of a document.

use std::fmt::Write as _;

use rayon::prelude::*;

use trocar_document::{DataTable, Document, Values, shortest};

use super::pictures::keep;
use super::{Folder, PictureError, to_json};

/// Writes the files of a document into a folder: its JSON, its data as CSV, its other files, and its figures in the formats of the
/// folder.
///
/// # Errors
/// [`PictureError`].
pub fn write_document(folder: &Folder, document: &Document<'_>) -> Result<(), PictureError> {
    folder.write(&format!("{}.json", document.name), to_json(&document.json).as_bytes())?;
    for table in &document.data {
        folder.write(&format!("{}.csv", table.name), csv(table).as_bytes())?;
    }
    for file in &document.files {
        folder.write(&file.name, file.text.as_bytes())?;
    }
    document.figures.par_iter().try_for_each(|(name, figure)| keep(folder, name, figure))
}

/// Returns columns as CSV. Floats have the shortest form that reads back to the same value; an undefined value is an empty cell.
fn csv(table: &DataTable<'_>) -> String {
    let names: Vec<String> = table.columns.iter().map(|column| quoted(&column.name)).collect();
    let mut text = names.join(",") + "\n";
    for row in 0..table.rows() {
        for (index, column) in table.columns.iter().enumerate() {
            if index > 0 {
                text.push(',');
            }
            // Writing to a string does not fail.
            let _ = match &column.values {
                Values::Numbers(values) => write!(text, "{}", shortest(values[row])),
                Values::Optional(values) => values[row].map_or(Ok(()), |value| write!(text, "{}", shortest(value))),
                Values::Whole(values) => write!(text, "{}", values[row]),
                Values::Codes(values) => write!(text, "{}", values[row]),
                Values::Flags(values) => values[row].map_or(Ok(()), |flag| write!(text, "{}", u8::from(flag))),
                Values::Texts(values) => write!(text, "{}", quoted(&values[row])),
            };
        }
        text.push('\n');
    }
    text
}

/// Returns a CSV cell, quoted if necessary.
pub(super) fn quoted(text: &str) -> String {
    if text.contains([',', '"']) { format!("\"{}\"", text.replace('"', "\"\"")) } else { text.to_owned() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn undefined_values_are_empty_cells_and_flags_are_1_and_0() {
        let table = DataTable::new("t")
            .texts("name", ["a,b", "c"])
            .optional("x_m", [Some(0.1), None])
            .flags("is_stable", [true, false])
            .with("count", Values::Whole(vec![3, 4]));
        assert_eq!(csv(&table), "name,x_m,is_stable,count\n\"a,b\",0.1,1,3\nc,,0,4\n");
    }
}
