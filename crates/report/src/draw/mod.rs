//! A figure is laid out on a sheet and drawn with plotters. Coordinates are integers, [`UNITS`] per point. The typeface
//! is bundled, so a figure has the same bytes everywhere.

mod animation;
mod bitmap;
mod canvas;
mod clip;
mod fonts;
mod format;
mod layout;
mod legend;
mod panel;
mod pdf;
mod pen;
mod svg;

pub(crate) use animation::animated_png;
use canvas::Backend;
pub use format::{FigureFormat, FigureStyle, FigureWidth};
use pen::Pen;

use plotters::coord::Shift;
use plotters::drawing::{DrawingArea, IntoDrawingArea};
use plotters::prelude::DrawingBackend;

use layout::Sheet;
use trocar_document::Figure;

/// Units of a drawing per point: finer than printers, and small files.
const UNITS: f64 = 100.0;

#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum DrawError {
    #[error("the figure is too large for a bitmap; choose a smaller --figure-width, or --figure-format svg,pdf")]
    Size,
    #[error("the figure cannot be encoded as PNG")]
    Png(#[from] png::EncodingError),
    #[error("the typeface cannot be embedded in a PDF")]
    Font,
    #[error("the figure cannot be compressed")]
    Deflate(#[source] std::io::Error),
    #[error("the figure cannot be drawn: {0}")]
    Backend(String),
}

pub fn file(figure: &Figure<'_>, format: FigureFormat, width: FigureWidth) -> Result<Vec<u8>, DrawError> {
    let sheet = Sheet::of(figure, width.points());
    match format {
        FigureFormat::Svg => Ok(svg::document(&sheet)?.into_bytes()),
        FigureFormat::Png => bitmap::png(&sheet),
        FigureFormat::Pdf => pdf::document(&sheet),
    }
}

fn units(points: f64) -> i32 {
    (UNITS * points).round() as i32
}

impl Sheet<'_> {
    fn size(&self) -> (u32, u32) {
        (units(self.width).unsigned_abs(), units(self.height).unsigned_abs())
    }

    fn draw_on<B: DrawingBackend>(&self, backend: B) -> Result<(), DrawError> {
        let area: DrawingArea<B, Shift> = backend.into_drawing_area();
        let drawn = self.draw(&Pen::new(&area, UNITS)).and_then(|()| area.present());
        drawn.map_err(|error| DrawError::Backend(error.to_string()))
    }
}

#[cfg(test)]
mod figures_tests;

#[cfg(test)]
pub(super) mod tests {
    use plotters_backend::BackendCoord;

    use super::canvas::{Canvas, Rgb};
    use super::*;

    pub(crate) fn svg(figure: &Figure<'_>, width: f64) -> String {
        svg::document(&Sheet::of(figure, width)).expect("a document")
    }

    /// With left, top, right and bottom in points.
    #[derive(Default)]
    pub(crate) struct Texts(pub(crate) Vec<(String, [f64; 4])>);

    impl Texts {
        /// The size of a sheet in points, and its texts.
        pub(crate) fn of(figure: &Figure<'_>, width: FigureWidth) -> ((f64, f64), Self) {
            let sheet = Sheet::of(figure, width.points());
            let mut texts = Self::default();
            sheet.draw_on(Backend { canvas: &mut texts, size: sheet.size() }).expect("drawn");
            ((sheet.width, sheet.height), texts)
        }
    }

    impl Canvas for Texts {
        fn stroke(&mut self, _: &[BackendCoord], _: u32, _: Rgb) {}

        fn fill(&mut self, _: &[BackendCoord], _: Rgb, _: bool) {}

        fn text(&mut self, text: &str, placed: &fonts::Placed) {
            self.0.push((text.to_owned(), placed.bounds().map(|edge| f64::from(edge) / UNITS)));
        }
    }
}
