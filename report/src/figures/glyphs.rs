//! Text on the bitmap, with the layout that an SVG viewer gives the SVG text of plotters.
//!
//! The bitmap text of plotters ignores the left bearing of each glyph and rounds its advance to whole pixels, which gives uneven
//! letter spacing.

use ab_glyph::{Font, FontRef, OutlineCurve};
use plotters_backend::text_anchor::{HPos, VPos};
use plotters_backend::{BackendCoord, BackendTextStyle, FontStyle, FontTransform};
use tiny_skia::{Path, PathBuilder, Transform};

use super::FigureError;
use super::fonts::{PLOTTERS_SIZE_PER_EM, faces, units_per_em};
use super::style::UNITS_PER_PIXEL;

/// Height of DejaVu's x relative to its em, for the `ex` in the SVG of plotters.
const EX: f32 = 0.547;

/// Returns the outlines of `text` in `style`, anchored at `at` (both in drawing units), and their transformation to the
/// bitmap; `None` for a text without ink.
pub(super) fn placed<S: BackendTextStyle>(
    text: &str,
    style: &S,
    at: BackendCoord,
) -> Result<Option<(Path, Transform)>, FigureError> {
    let faces = faces()?;
    let bold = matches!(style.style(), FontStyle::Bold);
    let face = if bold { &faces.bold } else { &faces.regular };
    let em = style.size() / PLOTTERS_SIZE_PER_EM / f64::from(UNITS_PER_PIXEL);
    let width = faces.width(text, em, bold) as f32;
    let em = em as f32;
    let anchor = style.anchor();
    let x = match anchor.h_pos {
        HPos::Left => 0.0,
        HPos::Center => -width / 2.0,
        HPos::Right => -width,
    };
    let baseline = match anchor.v_pos {
        VPos::Top => 0.76 * em,
        VPos::Center => 0.5 * EX * em,
        VPos::Bottom => -0.5 * EX * em,
    };
    let (left, top) = (at.0 as f32 / UNITS_PER_PIXEL as f32, at.1 as f32 / UNITS_PER_PIXEL as f32);
    let size = em / units_per_em(face);
    // A baseline on a whole pixel gives sharp letters.
    let placed = if matches!(style.transform(), FontTransform::Rotate270) {
        Transform::from_row(0.0, -size, -size, 0.0, (left + baseline).round(), top - x)
    } else {
        Transform::from_row(size, 0.0, 0.0, -size, left + x, (top + baseline).round())
    };
    Ok(outline(text, face).map(|outline| (outline, placed)))
}

/// Returns the outlines of `text` on one line from the origin, in the units of the face, positive upwards.
fn outline(text: &str, face: &FontRef<'_>) -> Option<Path> {
    let mut path = PathBuilder::new();
    let mut pen = 0.0;
    for c in text.chars() {
        let id = face.glyph_id(c);
        let mut last = None;
        for curve in face.outline(id).into_iter().flat_map(|outline| outline.curves) {
            let (OutlineCurve::Line(from, to) | OutlineCurve::Quad(from, _, to) | OutlineCurve::Cubic(from, _, _, to)) =
                curve;
            if last != Some(from) {
                path.move_to(pen + from.x, from.y);
            }
            last = Some(to);
            match curve {
                OutlineCurve::Line(_, to) => path.line_to(pen + to.x, to.y),
                OutlineCurve::Quad(_, a, to) => path.quad_to(pen + a.x, a.y, pen + to.x, to.y),
                OutlineCurve::Cubic(_, a, b, to) => path.cubic_to(pen + a.x, a.y, pen + b.x, b.y, pen + to.x, to.y),
            }
        }
        pen += face.h_advance_unscaled(id);
    }
    path.finish()
}
