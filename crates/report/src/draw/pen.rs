//! plotters supports neither dashes nor our typeface.

use std::cell::RefCell;

use plotters::coord::{CoordTranslate, Shift};
use plotters::drawing::{DrawingArea, DrawingAreaErrorKind};
use plotters::element::{Circle, PathElement, Polygon, Rectangle, Text as TextElement};
use plotters::prelude::DrawingBackend;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{Color as _, FontDesc, FontFamily, FontStyle, FontTransform, RGBColor, ShapeStyle, TextStyle};
use plotters_backend::BackendCoord;

use super::fonts;
use trocar_document::animation::Anchor;
use trocar_document::figure::{BLACK, Color, Point, Stroke};

pub(super) const TEXT: f64 = 8.0;
pub(super) const LINE: f64 = 10.0;

/// Tolerance of a merged straight line, in points.
const TOLERANCE: f64 = 0.03;
/// Maximum number of points merged into a straight line.
const MAX_MERGED: usize = 48;

/// Maximum number of dashes of a line. A noisy or oscillating line is much longer than its axes and is drawn solid,
/// because gaps would hide oscillations: a steady one would appear to beat.
const MAX_DASHES: f64 = 256.0;

pub(crate) type Drawn<B> = Result<(), DrawingAreaErrorKind<<B as DrawingBackend>::ErrorType>>;

/// A line of text. Its point is at the middle of its height; for an upright text, of its width.
#[derive(Clone, Debug)]
pub(crate) struct Text {
    pub(crate) text: String,
    pub(crate) at: Point,
    pub(crate) anchor: Anchor,
    pub(crate) size: f64,
    pub(crate) color: Color,
    pub(crate) is_bold: bool,
    /// True if the text reads upwards.
    pub(crate) is_upright: bool,
}

impl Text {
    pub(crate) fn new(text: impl Into<String>, at: Point, anchor: Anchor) -> Self {
        Self { text: text.into(), at, anchor, size: TEXT, color: BLACK, is_bold: false, is_upright: false }
    }
}

pub(crate) struct Pen<'a, B: DrawingBackend> {
    pub(super) area: &'a DrawingArea<B, Shift>,
    units: f64,
    /// The dashed strokes of the drawn lines; true if a line was too long for dashes.
    dashed: RefCell<Vec<(Stroke, bool)>>,
}

impl<'a, B: DrawingBackend> Pen<'a, B> {
    pub(crate) fn new(area: &'a DrawingArea<B, Shift>, units: f64) -> Self {
        Self { area, units, dashed: RefCell::default() }
    }

    /// Limited against overflow of sums.
    pub(crate) fn units(&self, points: f64) -> i32 {
        (self.units * points).round().clamp(-1e8, 1e8) as i32
    }

    fn at(&self, (x, y): Point) -> BackendCoord {
        (self.units(x), self.units(y))
    }

    fn path(&self, line: Vec<BackendCoord>, stroke: &Stroke) -> Drawn<B> {
        let width = self.units(stroke.width).max(1).unsigned_abs();
        self.area.draw(&PathElement::new(line, shape(stroke.color).stroke_width(width)))
    }

    pub(super) fn strokes(&self, lines: Vec<Vec<BackendCoord>>, stroke: &Stroke) -> Drawn<B> {
        let (dots, lines): (Vec<_>, Vec<_>) =
            lines.into_iter().filter(|line| !line.is_empty()).partition(|line| line.len() == 1);
        let length: f64 = lines.iter().flat_map(|line| line.windows(2)).map(|pair| distance(pair[0], pair[1])).sum();
        let dashes: Vec<f64> = stroke.dashes.iter().map(|length| self.units * length).collect();
        let is_solid = 0.5 * dashes.len() as f64 * length > MAX_DASHES * dashes.iter().sum::<f64>();
        if !lines.is_empty() && !dashes.is_empty() {
            self.dashed.borrow_mut().push((*stroke, is_solid));
        }
        for line in lines {
            let line = straightened(&line, self.units * TOLERANCE);
            if dashes.is_empty() || is_solid {
                self.path(line, stroke)?;
            } else {
                cut(&line, &dashes, self.units * stroke.width)
                    .into_iter()
                    .try_for_each(|dash| self.path(dash, stroke))?;
            }
        }
        let radius = self.units(0.5 * stroke.width + 0.2);
        dots.iter().try_for_each(|dot| self.area.draw(&Circle::new(dot[0], radius, shape(stroke.color).filled())))
    }

    pub(super) fn as_drawn(&self, stroke: &Stroke) -> Stroke {
        let dashed = self.dashed.borrow();
        let mut drawn = dashed.iter().filter(|(dashed, _)| dashed == stroke).peekable();
        let is_solid = drawn.peek().is_some() && drawn.all(|(_, is_solid)| *is_solid);
        Stroke { dashes: if is_solid { &[] } else { stroke.dashes }, ..*stroke }
    }

    pub(crate) fn line(&self, line: &[Point], stroke: &Stroke) -> Drawn<B> {
        self.strokes(vec![line.iter().map(|at| self.at(*at)).collect()], stroke)
    }

    pub(crate) fn fill(&self, outline: &[Point], color: Color) -> Drawn<B> {
        let outline: Vec<BackendCoord> = outline.iter().map(|at| self.at(*at)).collect();
        fill(self.area, &outline, color)
    }

    pub(super) fn alarm(&self, (x, y): BackendCoord) -> Drawn<B> {
        let (half, height) = (self.units(3.0), self.units(6.0));
        fill(self.area, &[(x - half, y), (x + half, y), (x, y + height)], BLACK)
    }

    pub(crate) fn text(&self, text: &Text) -> Drawn<B> {
        self.text_at(text, self.at(text.at))
    }

    pub(super) fn text_at(&self, text: &Text, (x, y): BackendCoord) -> Drawn<B> {
        let style = if text.is_bold { FontStyle::Bold } else { FontStyle::Normal };
        let font = FontDesc::new(FontFamily::Name(fonts::FAMILY), self.units * text.size * fonts::PER_SIZE, style);
        let (font, top) = if text.is_upright {
            (font.transform(FontTransform::Rotate270), (x - self.units(0.5 * text.size), y))
        } else {
            (font, (x, y - self.units(0.5 * text.size)))
        };
        let across = match text.anchor {
            Anchor::Start => HPos::Left,
            Anchor::Middle => HPos::Center,
            Anchor::End => HPos::Right,
        };
        let color = rgb(text.color);
        let style = TextStyle::from(font).color(&color).pos(Pos::new(across, VPos::Top));
        self.area.draw(&TextElement::new(text.text.as_str(), top, style))
    }
}

fn rgb(color: Color) -> RGBColor {
    RGBColor(color.0, color.1, color.2)
}

pub(super) fn shape(color: Color) -> ShapeStyle {
    ShapeStyle::from(rgb(color).to_rgba())
}

/// An upright rectangle has no smooth edges, against seams between neighbours.
pub(super) fn fill<B: DrawingBackend, C: CoordTranslate<From = (T, T)>, T: Copy + PartialEq + 'static>(
    area: &DrawingArea<B, C>,
    outline: &[(T, T)],
    color: Color,
) -> Drawn<B> {
    let style = shape(color).filled();
    match *outline {
        [a, b, c, d] if a.1 == b.1 && b.0 == c.0 && c.1 == d.1 && d.0 == a.0 => {
            area.draw(&Rectangle::new([a, c], style))
        }
        _ => area.draw(&Polygon::new(outline.to_vec(), style)),
    }
}

fn distance(a: BackendCoord, b: BackendCoord) -> f64 {
    f64::from(b.0 - a.0).hypot(f64::from(b.1 - a.1))
}

fn straightened(line: &[BackendCoord], tolerance: f64) -> Vec<BackendCoord> {
    let mut kept = vec![line[0]];
    let mut anchor = 0;
    for end in 2..line.len() {
        let between = &line[anchor + 1..end];
        if between.len() >= MAX_MERGED || between.iter().any(|&p| beside(p, line[anchor], line[end]) > tolerance) {
            anchor = end - 1;
            kept.push(line[anchor]);
        }
    }
    kept.push(line[line.len() - 1]);
    kept
}

fn beside(p: BackendCoord, a: BackendCoord, b: BackendCoord) -> f64 {
    let to = |q: BackendCoord| (f64::from(q.0 - a.0), f64::from(q.1 - a.1));
    let ((dx, dy), (ox, oy)) = (to(b), to(p));
    let length_squared = dx * dx + dy * dy;
    let t = if length_squared > 0.0 { ((ox * dx + oy * dy) / length_squared).clamp(0.0, 1.0) } else { 0.0 };
    (ox - t * dx).hypot(oy - t * dy)
}

/// Each dash is shortened by the line's width, because its ends are round.
fn cut(line: &[BackendCoord], dashes: &[f64], width: f64) -> Vec<Vec<BackendCoord>> {
    let mut lengths = dashes.iter().enumerate().cycle().map(|(index, length)| {
        let change = if index % 2 == 0 { -width.min(length - 1.0) } else { width.min(dashes[index - 1] - 1.0) };
        (index % 2 == 0, length + change)
    });
    let (mut is_on, mut left) = lengths.next().unwrap_or((true, f64::INFINITY));
    let (mut done, mut open) = (vec![], vec![line[0]]);
    for pair in line.windows(2) {
        let ((from, to), length) = ((pair[0], pair[1]), distance(pair[0], pair[1]));
        let mut walked = 0.0;
        while length - walked > left {
            walked += left;
            let share = |a: i32, b: i32| a + (f64::from(b - a) * walked / length).round() as i32;
            let at = (share(from.0, to.0), share(from.1, to.1));
            if is_on {
                open.push(at);
                done.push(std::mem::take(&mut open));
            } else {
                open = vec![at];
            }
            (is_on, left) = lengths.next().unwrap_or((true, f64::INFINITY));
        }
        left -= length - walked;
        if is_on {
            open.push(to);
        }
    }
    if is_on {
        done.push(open);
    }
    done
}

#[cfg(test)]
mod tests {
    use super::*;
    use plotters::prelude::{IntoDrawingArea, SVGBackend};
    use trocar_document::figure::{AUGMENTED, CLASSICAL};

    #[test]
    fn a_line_is_dashed_unless_it_oscillates_too_often() {
        let paths = |swings: f64| {
            let line: Vec<Point> =
                (0..8000).map(|k| 0.03 * f64::from(k)).map(|x| (x, 60.0 + 50.0 * (x * swings).sin())).collect();
            let mut svg = String::new();
            let area = SVGBackend::with_string(&mut svg, (24_000, 12_000)).into_drawing_area();
            let pen = Pen::new(&area, 100.0);
            pen.line(&line, &CLASSICAL).expect("drawn");
            assert_eq!(pen.as_drawn(&AUGMENTED), AUGMENTED, "no line has it");
            let is_dashed = !pen.as_drawn(&CLASSICAL).dashes.is_empty();
            drop(area);
            (svg.matches("<polyline").count() > 1, is_dashed)
        };
        assert_eq!((paths(0.1), paths(5.0)), ((true, true), (false, false)));
    }

    #[test]
    fn dashes_cover_their_share_of_a_line() {
        let dashes = cut(&[(0, 0), (500, 0), (500, 500)], &[60.0, 40.0], 20.0);
        let covered: f64 =
            dashes.iter().map(|dash| 20.0 + dash.windows(2).map(|p| distance(p[0], p[1])).sum::<f64>()).sum();
        assert!((covered - 600.0).abs() <= 20.0, "{covered}");
        assert_eq!(dashes[0], [(0, 0), (40, 0)]);
    }

    #[test]
    fn straight_lines_need_two_points() {
        let line: Vec<BackendCoord> = (0..=1000).map(|k| (5 * k, 100)).collect();
        assert!(straightened(&line, 3.0).len() < 40);
    }
}
