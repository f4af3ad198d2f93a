//! A plotters backend that draws every shape as SVG and on a bitmap. A figure is laid out once, so its two files agree.
//!
//! The bitmap replaces the bitmap backend of plotters, whose wide lines have ragged joints.

use std::io;

use plotters::backend::SVGBackend;
use plotters::coord::Shift;
use plotters::drawing::{DrawingArea, IntoDrawingArea};
use plotters_backend::{BackendColor, BackendCoord, BackendStyle, BackendTextStyle, DrawingBackend, DrawingErrorKind};
use tiny_skia::{FillRule, LineCap, LineJoin, Paint, Path, PathBuilder, Pixmap, Rect, Stroke, Transform};

use super::style::{FIGURE_WIDTH, UNITS_PER_PIXEL};
use super::{Figure, FigureError, fonts, glyphs};

/// The area on which figures are drawn.
pub(super) type Area<'a> = DrawingArea<Canvas<'a>, Shift>;

/// The backend. Coordinates are drawing units.
pub(super) struct Canvas<'a> {
    svg: SVGBackend<'a>,
    pixmap: &'a mut Pixmap,
}

type Drawn = Result<(), DrawingErrorKind<io::Error>>;

/// Runs `draw` on a blank page of the given height in pixels, and returns the figure.
pub(super) fn render(
    height: i32,
    draw: impl FnOnce(&Area<'_>) -> Result<(), FigureError>,
) -> Result<Figure, FigureError> {
    fonts::faces()?;
    let height = height.clamp(1, 20_000);
    let (wide, high) = (FIGURE_WIDTH * UNITS_PER_PIXEL, height * UNITS_PER_PIXEL);
    let mut svg = String::new();
    let mut pixmap = Pixmap::new(FIGURE_WIDTH as u32, height as u32).expect("neither side is 0 or enormous");
    let canvas = Canvas { svg: SVGBackend::with_string(&mut svg, (wide as u32, high as u32)), pixmap: &mut pixmap };
    let area = canvas.into_drawing_area();
    area.fill(&plotters::style::WHITE)?;
    draw(&area)?;
    area.present()?;
    drop(area);
    let svg = svg.replacen(
        &format!("width=\"{wide}\" height=\"{high}\""),
        &format!("width=\"{FIGURE_WIDTH}\" height=\"{height}\" stroke-linejoin=\"round\" stroke-linecap=\"round\""),
        1,
    );
    Ok(Figure { svg, png: png(&pixmap)? })
}

/// Encodes the opaque image as PNG. Compression is fast, because lines on white compress well at any setting.
fn png(pixmap: &Pixmap) -> Result<Vec<u8>, png::EncodingError> {
    let mut bytes = Vec::with_capacity(1 << 17);
    let mut encoder = png::Encoder::new(&mut bytes, pixmap.width(), pixmap.height());
    encoder.set_color(png::ColorType::Rgba);
    encoder.set_compression(png::Compression::Fast);
    encoder.set_filter(png::Filter::Up);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(pixmap.data())?;
    writer.finish()?;
    Ok(bytes)
}

/// Returns the transformation from drawing units to pixels.
fn to_pixels() -> Transform {
    let scale = 1.0 / UNITS_PER_PIXEL as f32;
    Transform::from_scale(scale, scale)
}

fn paint(color: BackendColor) -> Paint<'static> {
    let (r, g, b) = color.rgb;
    let mut paint = Paint::default();
    paint.set_color_rgba8(r, g, b, (color.alpha * 255.0).round() as u8);
    paint
}

fn path(points: &[BackendCoord]) -> Option<Path> {
    let mut path = PathBuilder::with_capacity(points.len() + 1, points.len());
    let (&first, rest) = points.split_first()?;
    path.move_to(first.0 as f32, first.1 as f32);
    for at in rest {
        path.line_to(at.0 as f32, at.1 as f32);
    }
    path.finish()
}

impl Canvas<'_> {
    fn fill(&mut self, path: Option<Path>, color: BackendColor) {
        if let Some(path) = path {
            self.pixmap.fill_path(&path, &paint(color), FillRule::EvenOdd, to_pixels(), None);
        }
    }

    fn stroke(&mut self, points: &[BackendCoord], style: &impl BackendStyle) {
        let width = style.stroke_width().max(UNITS_PER_PIXEL as u32) as f32;
        let stroke = Stroke { width, line_cap: LineCap::Round, line_join: LineJoin::Round, ..Stroke::default() };
        if let Some(path) = path(points) {
            self.pixmap.stroke_path(&path, &paint(style.color()), &stroke, to_pixels(), None);
        }
    }
}

impl DrawingBackend for Canvas<'_> {
    type ErrorType = io::Error;

    fn get_size(&self) -> (u32, u32) {
        self.svg.get_size()
    }

    fn ensure_prepared(&mut self) -> Drawn {
        self.svg.ensure_prepared()
    }

    fn present(&mut self) -> Drawn {
        self.svg.present()
    }

    fn draw_pixel(&mut self, (x, y): BackendCoord, color: BackendColor) -> Drawn {
        self.svg.draw_pixel((x, y), color)?;
        self.fill(Rect::from_xywh(x as f32, y as f32, 1.0, 1.0).map(PathBuilder::from_rect), color);
        Ok(())
    }

    fn draw_line<S: BackendStyle>(&mut self, from: BackendCoord, to: BackendCoord, style: &S) -> Drawn {
        self.svg.draw_line(from, to, style)?;
        self.stroke(&[from, to], style);
        Ok(())
    }

    fn draw_rect<S: BackendStyle>(&mut self, from: BackendCoord, to: BackendCoord, style: &S, fill: bool) -> Drawn {
        let corners = [from, (to.0, from.1), to, (from.0, to.1), from];
        if !fill {
            return self.draw_path(corners, style);
        }
        self.svg.draw_rect(from, to, style, true)?;
        self.fill(path(&corners), style.color());
        Ok(())
    }

    fn draw_path<S: BackendStyle, I: IntoIterator<Item = BackendCoord>>(&mut self, points: I, style: &S) -> Drawn {
        let points: Vec<BackendCoord> = points.into_iter().collect();
        self.svg.draw_path(points.iter().copied(), style)?;
        self.stroke(&points, style);
        Ok(())
    }

    fn draw_circle<S: BackendStyle>(&mut self, at: BackendCoord, radius: u32, style: &S, _fill: bool) -> Drawn {
        self.svg.draw_circle(at, radius, style, true)?;
        self.fill(PathBuilder::from_circle(at.0 as f32, at.1 as f32, radius as f32), style.color());
        Ok(())
    }

    fn fill_polygon<S: BackendStyle, I: IntoIterator<Item = BackendCoord>>(&mut self, outline: I, style: &S) -> Drawn {
        let outline: Vec<BackendCoord> = outline.into_iter().collect();
        self.svg.fill_polygon(outline.iter().copied(), style)?;
        self.fill(path(&outline), style.color());
        Ok(())
    }

    fn draw_text<S: BackendTextStyle>(&mut self, text: &str, style: &S, at: BackendCoord) -> Drawn {
        self.svg.draw_text(text, style, at)?;
        let placed =
            glyphs::placed(text, style, at).map_err(|error| DrawingErrorKind::DrawingError(io::Error::other(error)))?;
        if let Some((outline, place)) = placed {
            self.pixmap.fill_path(&outline, &paint(style.color()), FillRule::Winding, place, None);
        }
        Ok(())
    }
}
