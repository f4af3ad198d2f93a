//! Sizes, colours and line styles.
//!
//! Lengths are in pixels of a figure 1600 pixels wide. The colours are those of Okabe and Ito, which differ for the common forms of
//! colour blindness. Lines also differ in width and dashes, for print without colour.

use plotters::style::{Color, FontStyle, FontTransform, IntoFont, RGBAColor, RGBColor, ShapeStyle, TextStyle};

use super::fonts::{FAMILY, PLOTTERS_SIZE_PER_EM};

/// Drawing units per pixel. Plotters has integer coordinates; quarters of a pixel keep slow curves smooth.
pub(super) const UNITS_PER_PIXEL: i32 = 4;

pub(super) const FIGURE_WIDTH: i32 = 1600;
pub(super) const TEXT_EM: f64 = 34.0;
pub(super) const TITLE_EM: f64 = 36.0;

pub(super) const BLACK: RGBColor = RGBColor(0x1a, 0x1a, 0x1a);
pub(super) const GREY: RGBColor = RGBColor(0x6e, 0x6e, 0x6e);
pub(super) const GRID: RGBColor = RGBColor(0xe3, 0xe3, 0xe3);
pub(super) const ORANGE: RGBColor = RGBColor(0xe6, 0x9f, 0x00);
pub(super) const SKY: RGBColor = RGBColor(0x56, 0xb4, 0xe9);
pub(super) const GREEN: RGBColor = RGBColor(0x00, 0x9e, 0x73);
pub(super) const BLUE: RGBColor = RGBColor(0x00, 0x72, 0xb2);
pub(super) const VERMILION: RGBColor = RGBColor(0xd5, 0x5e, 0x00);
pub(super) const PURPLE: RGBColor = RGBColor(0xcc, 0x79, 0xa7);

/// Converts pixels to drawing units.
pub(super) fn units(pixels: f64) -> i32 {
    (pixels * f64::from(UNITS_PER_PIXEL)).round() as i32
}

/// The style of a line. Dashes are `(on, off, on, off …)` in pixels, empty for a solid line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Stroke {
    pub(super) color: RGBColor,
    pub(super) width: f64,
    pub(super) dashes: &'static [f32],
}

impl Stroke {
    pub(super) const fn solid(color: RGBColor, width: f64) -> Self {
        Self { color, width, dashes: &[] }
    }

    pub(super) fn shape(&self) -> ShapeStyle {
        ShapeStyle { color: self.color.to_rgba(), filled: false, stroke_width: units(self.width).max(1) as u32 }
    }
}

/// A wide pale line below a thin one.
pub(super) const UNDERLAY: Stroke = Stroke::solid(SKY, 8.0);
/// The main line.
pub(super) const MAIN: Stroke = Stroke::solid(VERMILION, 3.25);
/// The line of the operator or the master.
pub(super) const HUMAN: Stroke = Stroke { color: BLUE, width: 3.25, dashes: &[15.0, 10.0] };
/// The only line in its axes.
pub(super) const ALONE: Stroke = Stroke::solid(BLUE, 2.75);
/// A true rupture.
pub(super) const RUPTURE: Stroke = Stroke { color: GREY, width: 2.0, dashes: &[7.0, 7.0] };
/// An alarm.
pub(super) const ALARM: Stroke = Stroke::solid(BLACK, 2.0);
/// A threshold.
pub(super) const THRESHOLD: Stroke = Stroke { color: VERMILION, width: 3.0, dashes: &[22.0, 9.0, 3.0, 9.0] };

/// One style per run or detector in the same axes.
pub(super) const RUNS: [Stroke; 8] = [
    Stroke { color: BLUE, width: 3.25, dashes: &[15.0, 10.0] },
    Stroke::solid(VERMILION, 3.75),
    Stroke { color: GREEN, width: 3.5, dashes: &[26.0, 10.0, 4.0, 10.0] },
    Stroke { color: BLACK, width: 3.0, dashes: &[5.0, 8.0] },
    Stroke::solid(PURPLE, 2.25),
    Stroke { color: ORANGE, width: 4.5, dashes: &[34.0, 14.0] },
    Stroke { color: SKY, width: 6.0, dashes: &[10.0, 16.0] },
    Stroke::solid(GREY, 5.0),
];

/// Returns the shade of an interval in a mode, or `None` for teleoperation.
pub(super) fn shade(mode: u8) -> Option<RGBAColor> {
    match mode {
        1 => Some(ORANGE.mix(0.34)),
        2 => Some(ORANGE.mix(0.13)),
        _ => None,
    }
}

/// Body text.
pub(super) fn text() -> TextStyle<'static> {
    sized(TEXT_EM, FontStyle::Normal)
}

/// Titles of rows.
pub(super) fn title() -> TextStyle<'static> {
    sized(TITLE_EM, FontStyle::Bold)
}

fn sized(em: f64, style: FontStyle) -> TextStyle<'static> {
    let size = em * PLOTTERS_SIZE_PER_EM * f64::from(UNITS_PER_PIXEL);
    let font = (FAMILY, size).into_font().style(style).transform(FontTransform::None);
    TextStyle::from(font).color(&BLACK)
}
