//! A plotters backend that draws every shape twice, as SVG and on a bitmap, so that a figure is laid out once and both its files agree.

use std::io;

use plotters::backend::SVGBackend;
use plotters::coord::Shift;
use plotters::drawing::{DrawingArea, IntoDrawingArea};
use plotters_backend::{BackendColor, BackendCoord, BackendStyle, BackendTextStyle, DrawingBackend, DrawingErrorKind};

use super::raster::Raster;
use super::style::{FIGURE_WIDTH, UNITS_PER_PIXEL};
use super::{Figure, FigureError, fonts, glyphs};

/// The area figures draw on.
pub(super) type Area<'a> = DrawingArea<Canvas<'a>, Shift>;

/// The backend; its coordinates are drawing units.
pub(super) struct Canvas<'a> {
    svg: SVGBackend<'a>,
    raster: &'a mut Raster,
}

type Drawn = Result<(), DrawingErrorKind<io::Error>>;

/// Runs `draw` on a blank page `height` pixels high.
pub(super) fn render(
    height: i32,
    draw: impl FnOnce(&Area<'_>) -> Result<(), FigureError>,
) -> Result<Figure, FigureError> {
    fonts::faces()?;
    let height = height.clamp(1, 20_000);
    let (wide, high) = (FIGURE_WIDTH * UNITS_PER_PIXEL, height * UNITS_PER_PIXEL);
    let mut svg = String::new();
    let mut raster = Raster::new(FIGURE_WIDTH as usize, height as usize);
    let canvas = Canvas { svg: SVGBackend::with_string(&mut svg, (wide as u32, high as u32)), raster: &mut raster };
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
    Ok(Figure { svg, png: raster.png()? })
}

fn pixels(at: BackendCoord) -> (f32, f32) {
    let scale = 1.0 / UNITS_PER_PIXEL as f32;
    (at.0 as f32 * scale, at.1 as f32 * scale)
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

    fn draw_pixel(&mut self, point: BackendCoord, color: BackendColor) -> Drawn {
        self.svg.draw_pixel(point, color)?;
        let (x, y) = pixels(point);
        self.raster.blend(x as i32, y as i32, color, 1.0);
        Ok(())
    }

    fn draw_line<S: BackendStyle>(&mut self, from: BackendCoord, to: BackendCoord, style: &S) -> Drawn {
        self.svg.draw_line(from, to, style)?;
        let width = style.stroke_width() as f32 / UNITS_PER_PIXEL as f32;
        self.raster.line(&[pixels(from), pixels(to)], width, style.color());
        Ok(())
    }

    fn draw_rect<S: BackendStyle>(
        &mut self,
        upper_left: BackendCoord,
        bottom_right: BackendCoord,
        style: &S,
        fill: bool,
    ) -> Drawn {
        let (left, top) = upper_left;
        let (right, bottom) = bottom_right;
        if fill {
            self.svg.draw_rect(upper_left, bottom_right, style, true)?;
            self.raster.rectangle(pixels(upper_left), pixels(bottom_right), style.color());
            return Ok(());
        }
        let outline = [(left, top), (right, top), (right, bottom), (left, bottom), (left, top)];
        self.draw_path(outline, style)
    }

    fn draw_path<S: BackendStyle, I: IntoIterator<Item = BackendCoord>>(&mut self, path: I, style: &S) -> Drawn {
        let path: Vec<BackendCoord> = path.into_iter().collect();
        self.svg.draw_path(path.iter().copied(), style)?;
        let path: Vec<(f32, f32)> = path.into_iter().map(pixels).collect();
        let width = style.stroke_width() as f32 / UNITS_PER_PIXEL as f32;
        self.raster.line(&path, width, style.color());
        Ok(())
    }

    fn draw_circle<S: BackendStyle>(&mut self, center: BackendCoord, radius: u32, style: &S, _fill: bool) -> Drawn {
        self.svg.draw_circle(center, radius, style, true)?;
        let radius = radius as f32 / UNITS_PER_PIXEL as f32;
        self.raster.disc(pixels(center), radius, style.color());
        Ok(())
    }

    fn fill_polygon<S: BackendStyle, I: IntoIterator<Item = BackendCoord>>(&mut self, outline: I, style: &S) -> Drawn {
        let outline: Vec<BackendCoord> = outline.into_iter().collect();
        self.svg.fill_polygon(outline.iter().copied(), style)?;
        let outline: Vec<(f32, f32)> = outline.into_iter().map(pixels).collect();
        self.raster.polygon(&outline, style.color());
        Ok(())
    }

    fn draw_text<S: BackendTextStyle>(&mut self, text: &str, style: &S, at: BackendCoord) -> Drawn {
        self.svg.draw_text(text, style, at)?;
        glyphs::draw(self.raster, text, style, pixels(at))
            .map_err(|error| DrawingErrorKind::DrawingError(io::Error::other(error)))
    }
}
