//! Text on the bitmap, laid out as an SVG viewer lays out what plotters writes.
//!
//! Plotters' own bitmap text drops each glyph's left bearing and rounds its advance to whole pixels, which shows as uneven letters.

use ab_glyph::{Font, ScaleFont, point};
use plotters_backend::text_anchor::{HPos, VPos};
use plotters_backend::{BackendTextStyle, FontStyle, FontTransform};

use super::FigureError;
use super::fonts::{PLOTTERS_SIZE_PER_EM, faces, pixel_scale};
use super::raster::Raster;
use super::style::UNITS_PER_PIXEL;

/// Height of DejaVu's x over its em, for the `ex` in plotters' SVG.
const EX: f32 = 0.547;

/// Draws `text` anchored at `at` (pixels), in `style`, whose size is in drawing units.
pub(super) fn draw<S: BackendTextStyle>(
    raster: &mut Raster,
    text: &str,
    style: &S,
    at: (f32, f32),
) -> Result<(), FigureError> {
    let faces = faces()?;
    let bold = matches!(style.style(), FontStyle::Bold);
    let face = if bold { &faces.bold } else { &faces.regular };
    let em = (style.size() / PLOTTERS_SIZE_PER_EM / f64::from(UNITS_PER_PIXEL)) as f32;
    let font = face.as_scaled(pixel_scale(face, em));
    let width = faces.width(text, f64::from(em), bold) as f32;
    let anchor = style.anchor();
    let mut x = match anchor.h_pos {
        HPos::Left => 0.0,
        HPos::Center => -width / 2.0,
        HPos::Right => -width,
    };
    let baseline = match anchor.v_pos {
        VPos::Top => 0.76 * em,
        VPos::Center => 0.5 * EX * em,
        VPos::Bottom => -0.5 * EX * em,
    }
    .round();
    // Whole pixels stay whole when the text is turned; only the fraction along the line is kept.
    let turned = matches!(style.transform(), FontTransform::Rotate270);
    let origin = (at.0.floor() as i32, at.1.round() as i32);
    if !turned {
        x += at.0 - at.0.floor();
    }
    let color = style.color();
    for c in text.chars() {
        let id = font.glyph_id(c);
        let glyph = id.with_scale_and_position(font.scale(), point(x, baseline));
        x += font.h_advance(id);
        let Some(outline) = font.outline_glyph(glyph) else {
            continue;
        };
        let bounds = outline.px_bounds();
        let (left, top) = (bounds.min.x as i32, bounds.min.y as i32);
        outline.draw(|i, j, coverage| {
            let (u, v) = (left + i as i32, top + j as i32);
            let (px, py) = if turned { (v, -u - 1) } else { (u, v) };
            raster.blend(origin.0 + px, origin.1 + py, color, coverage);
        });
    }
    Ok(())
}
