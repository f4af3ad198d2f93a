use rayon::prelude::*;
use thiserror::Error;

use super::{Folder, OutputError};
use crate::draw::{DrawError, file};
use trocar_document::Figure;

#[derive(Debug, Error)]
pub enum PictureError {
    #[error(transparent)]
    Draw(#[from] DrawError),
    #[error(transparent)]
    Write(#[from] OutputError),
}

pub(super) fn keep(folder: &Folder, name: &str, figure: &Figure<'_>) -> Result<(), PictureError> {
    let style = &folder.figures;
    style.formats.par_iter().try_for_each(|format| {
        let file = file(figure, *format, style.width)?;
        Ok(folder.write(&format!("{name}.{}", format), &file)?)
    })
}
