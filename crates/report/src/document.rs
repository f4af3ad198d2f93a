use rayon::prelude::*;

use trocar_document::{DataTable, Document, to_json};

use super::draw::animated_png;
use super::pictures::keep;
use super::{ColumnFormat, Folder, OutputError, PictureError};

/// Figures and sampled data have the formats of the folder; other data are CSV.
pub fn write_document(folder: &Folder, document: &Document<'_>) -> Result<(), PictureError> {
    let files = || -> Result<(), OutputError> {
        folder.write(&format!("{}.json", document.name), to_json(&document.json).as_bytes())?;
        document.data.iter().try_for_each(|table| write_table(folder, table))?;
        document.files.iter().try_for_each(|file| folder.write(&file.name, file.text.as_bytes()))
    };
    let figures = || document.figures.par_iter().try_for_each(|(name, figure)| keep(folder, name, figure));
    let animation = || -> Result<(), PictureError> {
        let Some(animation) = document.animation.as_ref().filter(|animation| !animation.pictures.is_empty()) else {
            return Ok(());
        };
        Ok(folder.write("animation.png", &animated_png(animation)?)?)
    };
    let (files, (figures, animation)) = rayon::join(files, || rayon::join(figures, animation));
    files?;
    figures.and(animation)
}

fn write_table(folder: &Folder, table: &DataTable<'_>) -> Result<(), OutputError> {
    let formats = if table.is_sampled { folder.samples.as_slice() } else { &[ColumnFormat::Csv] };
    formats
        .iter()
        .try_for_each(|format| folder.stream(&format!("{}.{}", table.name, format), |out| format.write(table, out)))
}
