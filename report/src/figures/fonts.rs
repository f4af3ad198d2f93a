//! The bundled typeface. No system fonts are used, so a figure has the same bytes on every machine.
//!
//! `DejaVuSans.ttf` and `DejaVuSans-Bold.ttf` are subsets (Latin, Greek, the mathematical signs of the figures) of DejaVu Sans
//! 2.37. `fonts/LICENSE` is their licence.

use std::sync::OnceLock;

use ab_glyph::{Font, FontRef};
use plotters::style::{FontStyle, register_font};

use super::FigureError;

/// The font family in SVG files. Verdana has the widths of DejaVu, so a viewer without DejaVu gives the same layout.
pub(super) const FAMILY: &str = "DejaVu Sans, Verdana, sans-serif";

/// Plotters writes `size / 1.24` as the SVG font size. Sizes in this crate are that em, in pixels.
pub(super) const PLOTTERS_SIZE_PER_EM: f64 = 1.24;

static REGULAR: &[u8] = include_bytes!("fonts/DejaVuSans.ttf");
static BOLD: &[u8] = include_bytes!("fonts/DejaVuSans-Bold.ttf");

/// The two parsed faces.
pub(super) struct Faces {
    pub(super) regular: FontRef<'static>,
    pub(super) bold: FontRef<'static>,
}

/// Returns the faces. The first call registers them with plotters.
pub(super) fn faces() -> Result<&'static Faces, FigureError> {
    static FACES: OnceLock<Option<Faces>> = OnceLock::new();
    FACES
        .get_or_init(|| {
            register_font(FAMILY, FontStyle::Normal, REGULAR).ok()?;
            register_font(FAMILY, FontStyle::Bold, BOLD).ok()?;
            Some(Faces { regular: FontRef::try_from_slice(REGULAR).ok()?, bold: FontRef::try_from_slice(BOLD).ok()? })
        })
        .as_ref()
        .ok_or(FigureError::Font)
}

impl Faces {
    /// Returns the width of `text` at `em` pixels.
    pub(super) fn width(&self, text: &str, em: f64, bold: bool) -> f64 {
        let face = if bold { &self.bold } else { &self.regular };
        let advance: f32 = text.chars().map(|c| face.h_advance_unscaled(face.glyph_id(c))).sum();
        f64::from(advance / units_per_em(face)) * em
    }

    /// Returns `text` on one line. Text wider than `max_width` pixels is cut and ends with an ellipsis.
    pub(super) fn fit(&self, text: &str, em: f64, bold: bool, max_width: f64) -> String {
        let mut kept: String = text.chars().take(400).map(|c| if c.is_control() { ' ' } else { c }).collect();
        if self.width(&kept, em, bold) <= max_width {
            return kept;
        }
        while kept.pop().is_some() {
            let cut = format!("{}…", kept.trim_end());
            if self.width(&cut, em, bold) <= max_width {
                return cut;
            }
        }
        String::from("…")
    }
}

/// Returns the units of `face` per em.
pub(super) fn units_per_em(face: &FontRef<'_>) -> f32 {
    face.units_per_em().unwrap_or(2048.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_used_character_has_a_glyph() {
        let faces = faces().expect("fonts");
        for c in "−·²³⁰⁹⁻µθγσΔ×√±≥|…—éß".chars() {
            assert_ne!(faces.regular.glyph_id(c).0, 0, "no regular {c}");
            assert_ne!(faces.bold.glyph_id(c).0, 0, "no bold {c}");
        }
    }

    #[test]
    fn long_names_are_cut_to_the_available_width() {
        let faces = faces().expect("fonts");
        let cut = faces.fit(&"very long name ".repeat(50), 30.0, false, 300.0);
        assert!(cut.ends_with('…') && faces.width(&cut, 30.0, false) <= 300.0);
        assert_eq!(faces.fit("a\u{1}b", 30.0, false, 300.0), "a b");
    }
}
