use plotters_backend::BackendCoord;
use tiny_skia::{FillRule, LineCap, LineJoin, Paint, Path, PathBuilder, Pixmap, Stroke, Transform};
use ttf_parser::OutlineBuilder;

use super::canvas::{Backend, Canvas, Rgb};
use super::fonts::{Placed, typeface};
use super::layout::Sheet;
use super::{DrawError, UNITS};

const DOTS_PER_INCH: f64 = 300.0;
const POINTS_PER_INCH: f64 = 72.0;
const METRES_PER_INCH: f64 = 0.0254;

pub(super) fn png(sheet: &Sheet<'_>) -> Result<Vec<u8>, DrawError> {
    let scale = DOTS_PER_INCH / POINTS_PER_INCH;
    let pixels = |points: f64| (scale * points).round().clamp(1.0, 30_000.0) as u32;
    let bitmap = Bitmap::new(pixels(sheet.width), pixels(sheet.height), scale / UNITS);
    let mut canvas = bitmap.ok_or(DrawError::Size)?;
    sheet.draw_on(Backend { canvas: &mut canvas, size: sheet.size() })?;
    encode(&canvas.pixmap)
}

/// The lowest level of deflate: a quarter of the size of `Compression::Fast`, and most of what the highest level saves.
fn encode(pixmap: &Pixmap) -> Result<Vec<u8>, DrawError> {
    let mut bytes = Vec::with_capacity(1 << 17);
    let mut encoder = png::Encoder::new(&mut bytes, pixmap.width(), pixmap.height());
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_deflate_compression(png::DeflateCompression::Level(1));
    encoder.set_filter(png::Filter::Up);
    let per_metre = (DOTS_PER_INCH / METRES_PER_INCH).round() as u32;
    encoder.set_pixel_dims(Some(png::PixelDimensions { xppu: per_metre, yppu: per_metre, unit: png::Unit::Meter }));
    let mut writer = encoder.write_header()?;
    writer.write_image_data(&opaque(pixmap.data()))?;
    writer.finish()?;
    Ok(bytes)
}

pub(crate) fn opaque(pixels: &[u8]) -> Vec<u8> {
    let mut bytes = vec![0; pixels.len() / 4 * 3];
    let ((pixels, _), (shown, _)) = (pixels.as_chunks::<4>(), bytes.as_chunks_mut::<3>());
    for (rgb, [red, green, blue, _]) in shown.iter_mut().zip(pixels) {
        *rgb = [*red, *green, *blue];
    }
    bytes
}

pub(crate) struct Bitmap {
    pub(crate) pixmap: Pixmap,
    scale: Transform,
}

impl Bitmap {
    /// `None` if the size in pixels is too large.
    pub(crate) fn new(width: u32, height: u32, scale: f64) -> Option<Self> {
        let mut pixmap = Pixmap::new(width, height)?;
        pixmap.fill(tiny_skia::Color::WHITE);
        Some(Self { pixmap, scale: Transform::from_scale(scale as f32, scale as f32) })
    }
}

impl Canvas for Bitmap {
    fn stroke(&mut self, line: &[BackendCoord], width: u32, color: Rgb) {
        let (line_cap, line_join) = (LineCap::Round, LineJoin::Round);
        let stroke = Stroke { width: width as f32, line_cap, line_join, ..Stroke::default() };
        if let Some(path) = trace(line) {
            self.pixmap.stroke_path(&path, &paint(color), &stroke, self.scale, None);
        }
    }

    fn fill(&mut self, outline: &[BackendCoord], color: Rgb, is_smooth: bool) {
        let paint = Paint { anti_alias: is_smooth, ..paint(color) };
        if let Some(path) = trace(outline) {
            self.pixmap.fill_path(&path, &paint, FillRule::Winding, self.scale, None);
        }
    }

    fn text(&mut self, text: &str, placed: &Placed) {
        let (outline, units) = letters(text, placed.is_bold);
        let ((x, y), size) = (placed.start, placed.em / units);
        let place = if placed.is_upright {
            Transform::from_row(0.0, -size, -size, 0.0, x, y)
        } else {
            Transform::from_row(size, 0.0, 0.0, -size, x, y)
        };
        if let Some(outline) = outline {
            let place = place.post_concat(self.scale);
            self.pixmap.fill_path(&outline, &paint(placed.color), FillRule::Winding, place, None);
        }
    }
}

fn paint((red, green, blue): Rgb) -> Paint<'static> {
    let mut paint = Paint::default();
    paint.set_color_rgba8(red, green, blue, 255);
    paint
}

fn trace(points: &[BackendCoord]) -> Option<Path> {
    let mut path = PathBuilder::new();
    for (x, y) in points.iter().map(|(x, y)| (*x as f32, *y as f32)) {
        if path.is_empty() { path.move_to(x, y) } else { path.line_to(x, y) }
    }
    path.finish()
}

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
