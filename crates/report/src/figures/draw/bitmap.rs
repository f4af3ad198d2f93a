//! A backend of plotters that paints with tiny-skia, and figures as PNG.

use plotters::prelude::DrawingBackend;
use plotters_backend::{BackendColor, BackendCoord, BackendStyle, BackendTextStyle, DrawingErrorKind};
use tiny_skia::{FillRule, LineCap, LineJoin, Paint, Path, PathBuilder, Pixmap, Rect, Stroke, Transform};
use ttf_parser::OutlineBuilder;

use super::fonts::{Placed, typeface};
use super::layout::Sheet;
use super::{DrawError, UNITS};

/// Resolution of the bitmap.
const DOTS_PER_INCH: f64 = 300.0;
const POINTS_PER_INCH: f64 = 72.0;
const METRES_PER_INCH: f64 = 0.0254;

/// Returns the PNG file of a sheet, which states its resolution.
pub(super) fn png(sheet: &Sheet<'_>) -> Result<Vec<u8>, DrawError> {
    let scale = DOTS_PER_INCH / POINTS_PER_INCH;
    let pixels = |points: f64| (scale * points).round().clamp(1.0, 30_000.0) as u32;
    let mut pixmap = Pixmap::new(pixels(sheet.width), pixels(sheet.height)).ok_or(DrawError::Size)?;
    pixmap.fill(tiny_skia::Color::WHITE);
    sheet.draw_on(Bitmap::new(&mut pixmap, sheet.size(), (scale / UNITS) as f32))?;
    encode(&pixmap)
}

/// Encodes the opaque image. Compression is fast, because lines on white compress well at any setting.
fn encode(pixmap: &Pixmap) -> Result<Vec<u8>, DrawError> {
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

/// Paints on a pixmap. All colours are opaque.
pub(crate) struct Bitmap<'a> {
    pixmap: &'a mut Pixmap,
    size: (u32, u32),
    scale: Transform,
}

impl<'a> Bitmap<'a> {
    /// Returns a backend of a size in units, each of which is `scale` pixels.
    pub(crate) fn new(pixmap: &'a mut Pixmap, size: (u32, u32), scale: f32) -> Self {
        Self { pixmap, size, scale: Transform::from_scale(scale, scale) }
    }

    fn fill(&mut self, path: Option<Path>, color: (u8, u8, u8), is_smooth: bool, place: Transform) -> Done {
        if let Some(path) = path {
            let paint = Paint { anti_alias: is_smooth, ..paint(color) };
            self.pixmap.fill_path(&path, &paint, FillRule::Winding, place, None);
        }
        Ok(())
    }
}

type Done = Result<(), DrawingErrorKind<std::convert::Infallible>>;

impl DrawingBackend for Bitmap<'_> {
    type ErrorType = std::convert::Infallible;

    fn get_size(&self) -> (u32, u32) {
        self.size
    }

    fn ensure_prepared(&mut self) -> Done {
        Ok(())
    }

    fn present(&mut self) -> Done {
        Ok(())
    }

    fn draw_pixel(&mut self, (x, y): BackendCoord, color: BackendColor) -> Done {
        self.draw_rect((x, y), (x + 1, y + 1), &color, true)
    }

    fn draw_line<S: BackendStyle>(&mut self, from: BackendCoord, to: BackendCoord, style: &S) -> Done {
        self.draw_path([from, to], style)
    }

    /// Fills a rectangle without smooth edges, so that no seams show between neighbours.
    fn draw_rect<S: BackendStyle>(&mut self, from: BackendCoord, to: BackendCoord, style: &S, fill: bool) -> Done {
        let [left, top, right, bottom] = [from.0, from.1, to.0, to.1].map(|place| place as f32);
        if fill {
            let rectangle = Rect::from_ltrb(left, top, right, bottom).map(PathBuilder::from_rect);
            return self.fill(rectangle, style.color().rgb, false, self.scale);
        }
        self.draw_path([from, (to.0, from.1), to, (from.0, to.1), from], style)
    }

    fn draw_path<S: BackendStyle, I: IntoIterator<Item = BackendCoord>>(&mut self, line: I, style: &S) -> Done {
        if let Some(path) = trace(line).finish() {
            let (line_cap, line_join) = (LineCap::Round, LineJoin::Round);
            let stroke = Stroke { width: style.stroke_width() as f32, line_cap, line_join, ..Stroke::default() };
            self.pixmap.stroke_path(&path, &paint(style.color().rgb), &stroke, self.scale, None);
        }
        Ok(())
    }

    fn fill_polygon<S: BackendStyle, I: IntoIterator<Item = BackendCoord>>(&mut self, outline: I, style: &S) -> Done {
        self.fill(trace(outline).finish(), style.color().rgb, true, self.scale)
    }

    fn draw_circle<S: BackendStyle>(&mut self, (x, y): BackendCoord, radius: u32, style: &S, _: bool) -> Done {
        let circle = PathBuilder::from_circle(x as f32, y as f32, radius as f32);
        self.fill(circle, style.color().rgb, true, self.scale)
    }

    fn draw_text<S: BackendTextStyle>(&mut self, text: &str, style: &S, at: BackendCoord) -> Done {
        let placed = Placed::of(text, style, at);
        let (outline, units) = letters(text, placed.is_bold);
        let ((x, y), size) = (placed.start, placed.em / units);
        let place = if placed.is_upright {
            Transform::from_row(0.0, -size, -size, 0.0, x, y)
        } else {
            Transform::from_row(size, 0.0, 0.0, -size, x, y)
        };
        self.fill(outline, placed.color, true, place.post_concat(self.scale))
    }
}

fn paint((red, green, blue): (u8, u8, u8)) -> Paint<'static> {
    let mut paint = Paint::default();
    paint.set_color_rgba8(red, green, blue, 255);
    paint
}

fn trace(points: impl IntoIterator<Item = BackendCoord>) -> PathBuilder {
    let mut path = PathBuilder::new();
    for (x, y) in points.into_iter().map(|(x, y)| (x as f32, y as f32)) {
        if path.is_empty() { path.move_to(x, y) } else { path.line_to(x, y) }
    }
    path
}

/// Returns the outlines of the letters of a text, upwards, in units of the face, and the number of units of an em.
fn letters(text: &str, is_bold: bool) -> (Option<Path>, f32) {
    let typeface = typeface(is_bold);
    let em = f32::from(typeface.face.units_per_em());
    let mut pen = Outline { path: PathBuilder::new(), x: 0.0 };
    for letter in text.chars() {
        let glyph = typeface.glyph(letter);
        typeface.face.outline_glyph(glyph, &mut pen);
        pen.x += typeface.advance(glyph) as f32 * em;
    }
    (pen.path.finish(), em)
}

/// Collects the outlines of glyphs, one after the other.
struct Outline {
    path: PathBuilder,
    x: f32,
}

impl OutlineBuilder for Outline {
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
