//! Figures as PNG.

use tiny_skia::{FillRule, LineCap, LineJoin, Paint, Path, PathBuilder, Pixmap, Stroke, StrokeDash, Transform};
use ttf_parser::OutlineBuilder;

use super::FigureError;
use super::fonts::typeface;
use super::page::{Item, Page, Point, Text, is_rectangle};
use super::style::{Color, TEXT};

/// Resolution of the bitmap.
pub(super) const DOTS_PER_INCH: f64 = 300.0;
const POINTS_PER_INCH: f64 = 72.0;
const METRES_PER_INCH: f64 = 0.0254;

impl Page {
    /// Returns the PNG file, which states its resolution.
    pub(super) fn png(&self) -> Result<Vec<u8>, FigureError> {
        let scale = DOTS_PER_INCH / POINTS_PER_INCH;
        let pixels = |points: f64| (scale * points).round().clamp(1.0, 30_000.0) as u32;
        let mut pixmap = Pixmap::new(pixels(self.width), pixels(self.height)).ok_or(FigureError::Size)?;
        pixmap.fill(tiny_skia::Color::WHITE);
        let scale = Transform::from_scale(scale as f32, scale as f32);
        for item in &self.items {
            item.draw(&mut pixmap, scale);
        }
        encode(&pixmap)
    }
}

/// Encodes the opaque image. Compression is fast, because lines on white compress well at any setting.
fn encode(pixmap: &Pixmap) -> Result<Vec<u8>, FigureError> {
    let mut bytes = Vec::with_capacity(1 << 17);
    let mut encoder = png::Encoder::new(&mut bytes, pixmap.width(), pixmap.height());
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_compression(png::Compression::Fast);
    encoder.set_filter(png::Filter::Up);
    let per_metre = (DOTS_PER_INCH / METRES_PER_INCH).round() as u32;
    encoder.set_pixel_dims(Some(png::PixelDimensions { xppu: per_metre, yppu: per_metre, unit: png::Unit::Meter }));
    let mut writer = encoder.write_header()?;
    writer.write_image_data(&opaque(pixmap.data()))?;
    writer.finish()?;
    Ok(bytes)
}

/// Returns the red, green and blue of opaque pixels of four bytes.
pub(crate) fn opaque(pixels: &[u8]) -> Vec<u8> {
    let mut bytes = vec![0; pixels.len() / 4 * 3];
    let ((pixels, _), (shown, _)) = (pixels.as_chunks::<4>(), bytes.as_chunks_mut::<3>());
    for (rgb, [red, green, blue, _]) in shown.iter_mut().zip(pixels) {
        *rgb = [*red, *green, *blue];
    }
    bytes
}

impl Item {
    fn draw(&self, pixmap: &mut Pixmap, scale: Transform) {
        let mut fill = |path: Option<Path>, color: Color, place: Transform| {
            if let Some(path) = path {
                pixmap.fill_path(&path, &paint(color), FillRule::Winding, place, None);
            }
        };
        match self {
            Self::Lines(lines, stroke) => {
                let dashes = stroke.dashes.iter().map(|length| *length as f32).collect();
                let style = Stroke {
                    width: stroke.width as f32,
                    line_cap: if stroke.dashes.is_empty() { LineCap::Round } else { LineCap::Butt },
                    line_join: LineJoin::Round,
                    dash: StrokeDash::new(dashes, 0.0),
                    ..Stroke::default()
                };
                let mut path = PathBuilder::new();
                lines.iter().for_each(|line| trace(line, &mut path));
                if let Some(path) = path.finish() {
                    pixmap.stroke_path(&path, &paint(stroke.color), &style, scale, None);
                }
            }
            Self::Area(outline, color) => {
                let mut path = PathBuilder::new();
                trace(outline, &mut path);
                let paint = Paint { anti_alias: !is_rectangle(outline), ..paint(*color) };
                if let Some(path) = path.finish() {
                    pixmap.fill_path(&path, &paint, FillRule::Winding, scale, None);
                }
            }
            Self::Dot((x, y), radius, color) => {
                fill(PathBuilder::from_circle(*x as f32, *y as f32, *radius as f32), *color, scale);
            }
            Self::Text(text) => {
                let (outline, place) = text.outline();
                fill(outline, super::style::BLACK, place.post_concat(scale));
            }
        }
    }
}

fn paint(Color(red, green, blue): Color) -> Paint<'static> {
    let mut paint = Paint::default();
    paint.set_color_rgba8(red, green, blue, 255);
    paint
}

fn trace(points: &[Point], path: &mut PathBuilder) {
    for (index, (x, y)) in points.iter().map(|at| (at.0 as f32, at.1 as f32)).enumerate() {
        if index == 0 { path.move_to(x, y) } else { path.line_to(x, y) }
    }
}

impl Text {
    /// Returns the outlines of the letters in units of the face, upwards, and their place on the page.
    fn outline(&self) -> (Option<Path>, Transform) {
        let (outline, em) = letters(&self.text, self.is_bold);
        let ((x, y), size) = (self.start(), TEXT as f32 / em);
        let (x, y) = (x as f32, y as f32);
        let place = if self.is_upright {
            Transform::from_row(0.0, -size, -size, 0.0, x, y)
        } else {
            Transform::from_row(size, 0.0, 0.0, -size, x, y)
        };
        (outline, place)
    }
}

/// Returns the outlines of the letters of a text, upwards, in units of the face, and the number of units of an em.
pub(crate) fn letters(text: &str, is_bold: bool) -> (Option<Path>, f32) {
    let typeface = typeface(is_bold);
    let em = f32::from(typeface.face.units_per_em());
    let mut pen = Pen { path: PathBuilder::new(), x: 0.0 };
    for letter in text.chars() {
        let glyph = typeface.glyph(letter);
        typeface.face.outline_glyph(glyph, &mut pen);
        pen.x += typeface.advance(glyph) as f32 * em;
    }
    (pen.path.finish(), em)
}

/// Collects the outlines of glyphs, one after the other.
struct Pen {
    path: PathBuilder,
    x: f32,
}

impl OutlineBuilder for Pen {
    fn move_to(&mut self, x: f32, y: f32) {
        self.path.move_to(self.x + x, y);
    }

    fn line_to(&mut self, x: f32, y: f32) {
        self.path.line_to(self.x + x, y);
    }

    fn quad_to(&mut self, x1: f32, y1: f32, x: f32, y: f32) {
        self.path.quad_to(self.x + x1, y1, self.x + x, y);
    }

    fn curve_to(&mut self, x1: f32, y1: f32, x2: f32, y2: f32, x: f32, y: f32) {
        self.path.cubic_to(self.x + x1, y1, self.x + x2, y2, self.x + x, y);
    }

    fn close(&mut self) {
        self.path.close();
    }
}
