//! The bundled typeface: without system fonts a figure has the same bytes everywhere.
//!
//! `DejaVuSans.ttf` and `DejaVuSans-Bold.ttf` are subsets of DejaVu Sans 2.37 (Latin, Greek, the mathematical signs of
//! the figures). `fonts/LICENSE` is their licence.

use std::sync::OnceLock;

use plotters_backend::text_anchor::HPos;
use plotters_backend::{BackendCoord, BackendTextStyle, FontStyle, FontTransform};
use ttf_parser::{Face, GlyphId};

/// The font family in SVG files. Verdana has the widths of DejaVu, so the layout stays the same without DejaVu.
pub(super) const FAMILY: &str = "DejaVu Sans, Verdana, sans-serif";

/// Size of a plotters font relative to the em.
pub(super) const PER_SIZE: f64 = 1.24;

/// Height of the letters above the baseline relative to the em. plotters places a text by its top.
const ASCENT: f64 = 0.76;

/// Maximum number of lines of a text; the rest is cut.
const MAX_LINES: usize = 3;

pub(super) struct Typeface {
    pub(super) name: &'static str,
    pub(super) data: &'static [u8],
    pub(super) face: Face<'static>,
}

pub(super) fn typeface(is_bold: bool) -> &'static Typeface {
    static FACES: [OnceLock<Typeface>; 2] = [OnceLock::new(), OnceLock::new()];
    FACES[usize::from(is_bold)].get_or_init(|| {
        let (name, data): (_, &'static [u8]) = if is_bold {
            ("DejaVuSans-Bold", include_bytes!("DejaVuSans-Bold.ttf"))
        } else {
            ("DejaVuSans", include_bytes!("DejaVuSans.ttf"))
        };
        Typeface { name, data, face: Face::parse(data, 0).expect("the bundled typeface is valid") }
    })
}

impl Typeface {
    pub(super) fn glyph(&self, letter: char) -> GlyphId {
        self.face.glyph_index(letter).unwrap_or(GlyphId(0))
    }

    /// The advance of a glyph relative to the em.
    pub(super) fn advance(&self, glyph: GlyphId) -> f64 {
        f64::from(self.face.glyph_hor_advance(glyph).unwrap_or(0)) / f64::from(self.face.units_per_em())
    }
}

pub(crate) fn width(text: &str, size: f64, is_bold: bool) -> f64 {
    let face = typeface(is_bold);
    text.chars().map(|letter| face.advance(face.glyph(letter))).sum::<f64>() * size
}

pub(crate) struct Placed {
    /// The start of the baseline.
    pub(super) start: (f32, f32),
    pub(super) em: f32,
    pub(super) is_bold: bool,
    /// True if the text reads upwards.
    pub(super) is_upright: bool,
    pub(super) color: (u8, u8, u8),
    #[cfg(test)]
    width: f32,
}

impl Placed {
    pub(super) fn of<S: BackendTextStyle>(text: &str, style: &S, (x, y): BackendCoord) -> Self {
        let em = style.size() / PER_SIZE;
        let is_bold = matches!(style.style(), FontStyle::Bold);
        let is_upright = matches!(style.transform(), FontTransform::Rotate270);
        let width = width(text, em, is_bold);
        let back = match style.anchor().h_pos {
            HPos::Left => 0.0,
            HPos::Center => 0.5 * width,
            HPos::Right => width,
        };
        let (x, y, down) = (f64::from(x), f64::from(y), ASCENT * em);
        let (x, y) = if is_upright { (x + down, y + back) } else { (x - back, y + down) };
        Self {
            start: (x as f32, y as f32),
            em: em as f32,
            is_bold,
            is_upright,
            color: style.color().rgb,
            #[cfg(test)]
            width: width as f32,
        }
    }

    #[cfg(test)]
    pub(super) fn bounds(&self) -> [f32; 4] {
        let ((x, y), above) = (self.start, ASCENT as f32 * self.em);
        let below = self.em - above;
        if self.is_upright {
            [x - above, y - self.width, x + below, y]
        } else {
            [x, y - above, x + self.width, y + below]
        }
    }
}

/// Breaks a text at spaces into lines of at most `max_width`. A longer word, and text beyond the third line, ends with
/// an ellipsis.
pub(super) fn lines(text: &str, size: f64, is_bold: bool, max_width: f64) -> Vec<String> {
    let clean: String = text.chars().take(400).map(|c| if c.is_control() { ' ' } else { c }).collect();
    let mut lines: Vec<String> = vec![];
    let mut words = clean.split(' ').filter(|word| !word.is_empty()).peekable();
    while let Some(word) = words.next() {
        let longer = lines.last().map(|line| format!("{line} {word}"));
        match longer.filter(|line| width(line, size, is_bold) <= max_width) {
            Some(longer) => *lines.last_mut().expect("there is a line") = longer,
            None if lines.len() < MAX_LINES => lines.push(word.to_owned()),
            None => {
                let rest = std::iter::once(word).chain(words.by_ref());
                let last = lines.last_mut().expect("there is a line");
                rest.for_each(|word| last.extend([" ", word]));
            }
        }
    }
    lines.into_iter().map(|line| cut(line, size, is_bold, max_width)).collect()
}

fn cut(mut text: String, size: f64, is_bold: bool, max_width: f64) -> String {
    if width(&text, size, is_bold) <= max_width {
        return text;
    }
    while text.pop().is_some() {
        let shorter = format!("{}…", text.trim_end());
        if width(&shorter, size, is_bold) <= max_width {
            return shorter;
        }
    }
    String::from("…")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_used_character_has_a_glyph() {
        for c in "−·²³⁰⁹⁻µθγσΔ×√±≥|…—°η".chars() {
            for is_bold in [false, true] {
                assert_ne!(typeface(is_bold).glyph(c).0, 0, "no {c}, bold: {is_bold}");
            }
        }
    }

    #[test]
    fn long_names_are_broken_and_then_cut_to_the_width() {
        let broken = lines(&"very long name ".repeat(50), 8.0, false, 100.0);
        assert_eq!(broken.len(), MAX_LINES);
        assert!(broken[2].ends_with('…') && broken.iter().all(|line| width(line, 8.0, false) <= 100.0), "{broken:?}");
        assert_eq!(lines("a\u{1}b", 8.0, false, 100.0), ["a b"]);
        assert_eq!(lines("", 8.0, false, 100.0), [""; 0]);
    }
}
