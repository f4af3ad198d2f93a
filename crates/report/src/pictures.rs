//! The files of figures.

use rayon::prelude::*;
use serde_json::Value as Json;
use thiserror::Error;

use super::{Folder, OutputError};
use crate::draw::{DrawError, file};
use trocar_document::Figure;
use trocar_figures::{self as figures, FigureError, RunView};

/// The error of drawing or writing figures.
#[derive(Debug, Error)]
pub enum PictureError {
    /// A figure could not be described.
    #[error(transparent)]
    Describe(#[from] FigureError),
    /// A figure could not be drawn.
    #[error(transparent)]
    Draw(#[from] DrawError),
    /// A file could not be written.
    #[error(transparent)]
    Write(#[from] OutputError),
    /// The page of figures could not be rendered.
    #[error("cannot render the page: {0}")]
    Page(#[source] minijinja::Error),
}

/// Writes the files of a figure: one for each format of the folder's style.
pub(super) fn keep(folder: &Folder, name: &str, figure: &Figure<'_>) -> Result<(), PictureError> {
    let style = folder.figures();
    style.formats.par_iter().try_for_each(|format| {
        let file = file(figure, *format, style.width)?;
        Ok(folder.write(&format!("{name}.{}", format.word()), &file)?)
    })
}

/// Describes the figure of the forces and positions of a run without its signals, which a page adds.
///
/// # Errors
/// [`FigureError`].
pub fn teleoperation_axes(is_augmented: bool) -> Result<Json, FigureError> {
    let zero: &[f64] = &[0.0];
    let view = RunView {
        name: "",
        is_augmented,
        time_s: zero,
        master_position_m: zero,
        slave_position_m: zero,
        operator_force_n: zero,
        tissue_force_n: zero,
        feedback_force_n: zero,
        mode: &[0],
        rupture_times_s: vec![].into(),
        alarm_times_s: vec![].into(),
    };
    Ok(figures::comparison(&[view], None)?.for_page(1))
}
