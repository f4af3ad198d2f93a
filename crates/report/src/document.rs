//! The files of a document.

use std::io::{self, Write};

use rayon::prelude::*;

use trocar_document::{DataColumn, DataTable, Document, Values};
use trocar_engine::engine::ColumnValues;

use super::columns::Column;
use super::pictures::keep;
use super::{ColumnFormat, Folder, OutputError, PictureError, to_json};

/// Writes the files of a document into a folder: its JSON, its data, its other files, and its figures. Figures and data with a row per
/// sample have the formats of the folder, other data are CSV.
///
/// # Errors
/// [`PictureError`].
pub fn write_document(folder: &Folder, document: &Document<'_>) -> Result<(), PictureError> {
    let files = || -> Result<(), OutputError> {
        folder.write(&format!("{}.json", document.name), to_json(&document.json).as_bytes())?;
        for table in &document.data {
            let formats = if table.is_sampled { folder.samples() } else { &[ColumnFormat::Csv] };
            formats.iter().try_for_each(|format| write_table(folder, table, *format))?;
        }
        document.files.iter().try_for_each(|file| folder.write(&file.name, file.text.as_bytes()))
    };
    let figures = || document.figures.par_iter().try_for_each(|(name, figure)| keep(folder, name, figure));
    let (files, figures) = rayon::join(files, figures);
    files?;
    figures
}

/// Writes a table as a file of a format. Only CSV has other columns than numbers and codes.
///
/// # Errors
/// [`OutputError`].
pub fn write_table(folder: &Folder, table: &DataTable<'_>, format: ColumnFormat) -> Result<(), OutputError> {
    folder.stream(&format!("{}.{}", table.name, format.word()), |out| match format {
        ColumnFormat::Csv => csv(table, out),
        _ => format.write(&table.name, &columns(table)?, out),
    })
}

fn columns<'a>(table: &'a DataTable<'_>) -> io::Result<Vec<Column<'a>>> {
    let column = |DataColumn { name, values }: &'a DataColumn<'_>| match values {
        Values::Numbers(numbers) => Ok((&**name, ColumnValues::Numbers(&**numbers))),
        Values::Codes(codes) => Ok((&**name, ColumnValues::Codes(&**codes))),
        _ => Err(io::Error::other(format!("the column {name} has neither numbers nor codes; write CSV"))),
    };
    table.columns.iter().map(column).collect()
}

/// Writes columns as CSV, line by line. Floats have the shortest form that reads back to the same value; an undefined value is an
/// empty cell.
fn csv(table: &DataTable<'_>, out: &mut dyn Write) -> io::Result<()> {
    let names: Vec<_> = table.columns.iter().map(|column| quoted(&column.name)).collect();
    writeln!(out, "{}", names.join(","))?;
    let mut numbers = ryu::Buffer::new();
    for row in 0..table.rows() {
        for (index, column) in table.columns.iter().enumerate() {
            if index > 0 {
                out.write_all(b",")?;
            }
            match &column.values {
                Values::Numbers(values) => out.write_all(numbers.format(values[row]).as_bytes())?,
                Values::Optional(values) => {
                    values[row].map_or(Ok(()), |value| out.write_all(numbers.format(value).as_bytes()))?;
                }
                Values::Whole(values) => write!(out, "{}", values[row])?,
                Values::OptionalWhole(values) => values[row].map_or(Ok(()), |value| write!(out, "{value}"))?,
                Values::Codes(values) => write!(out, "{}", values[row])?,
                Values::Flags(values) => values[row].map_or(Ok(()), |flag| write!(out, "{}", u8::from(flag)))?,
                Values::Texts(values) => write!(out, "{}", quoted(&values[row]))?,
            }
        }
        out.write_all(b"\n")?;
    }
    Ok(())
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
            .whole("count", [3, 4])
            .with("sample", Values::OptionalWhole(vec![None, Some(5)]));
        let mut text = vec![];
        csv(&table, &mut text).expect("written");
        let expected = "name,x_m,is_stable,count,sample\n\"a,b\",0.1,1,3,\nc,,0,4,5\n";
        assert_eq!(String::from_utf8(text).expect("text"), expected);
        assert!(columns(&table).expect_err("texts").to_string().contains("the column name"));
    }
}
