//! A figure laid out on its page: lines, areas and texts at their places, for the files to draw.

use super::fonts;
use super::style::{BLACK, Color, Stroke, TEXT};

/// A place, in points from the top left corner.
pub(super) type Point = (f64, f64);

/// Height of a line of text.
pub(super) const LINE: f64 = 10.0;
/// Height of the letters above the baseline, and below it, relative to the size.
const ASCENT: f64 = 0.76;
const DESCENT: f64 = 0.24;

/// Maximum number of dashes of a line. A noisy or swinging line is much longer than its axes are wide. It is solid: gaps would hide
/// some swings and not others, so that a steady swing would appear to beat.
const MAX_DASHES: f64 = 256.0;

/// Which part of a text is at its place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Anchor {
    Start,
    Middle,
    End,
}

/// A line of text of the size [`TEXT`].
#[derive(Clone, Debug)]
pub(super) struct Text {
    pub(super) text: String,
    /// The anchor's place on the baseline.
    pub(super) at: Point,
    pub(super) anchor: Anchor,
    pub(super) is_bold: bool,
    /// Whether it reads upwards.
    pub(super) is_upright: bool,
}

impl Text {
    pub(super) fn new(text: impl Into<String>, at: Point, anchor: Anchor) -> Self {
        Self { text: text.into(), at, anchor, is_bold: false, is_upright: false }
    }

    pub(super) fn width(&self) -> f64 {
        fonts::width(&self.text, TEXT, self.is_bold)
    }

    /// Returns where the text begins.
    pub(super) fn start(&self) -> Point {
        let back = match self.anchor {
            Anchor::Start => 0.0,
            Anchor::Middle => 0.5 * self.width(),
            Anchor::End => self.width(),
        };
        if self.is_upright { (self.at.0, self.at.1 + back) } else { (self.at.0 - back, self.at.1) }
    }

    /// Returns the left, top, right and bottom of the text.
    #[cfg(test)]
    pub(super) fn bounds(&self) -> [f64; 4] {
        let (x, y) = self.start();
        if self.is_upright {
            [x - ASCENT * TEXT, y - self.width(), x + DESCENT * TEXT, y]
        } else {
            [x, y - ASCENT * TEXT, x + self.width(), y + DESCENT * TEXT]
        }
    }
}

/// Returns the baseline of a text whose letters are centred on a height.
pub(super) fn centred(middle: f64) -> f64 {
    middle + 0.5 * (ASCENT - DESCENT) * TEXT
}

/// What is drawn.
#[derive(Clone, Debug)]
pub(super) enum Item {
    Lines(Vec<Vec<Point>>, Stroke),
    Area(Vec<Point>, Color),
    Dot(Point, f64, Color),
    Text(Text),
}

/// Whether an outline is an upright rectangle. It is drawn without smooth edges, so that no seams show between neighbours.
pub(super) fn is_rectangle(outline: &[Point]) -> bool {
    let [a, b, c, d] = outline else { return false };
    a.1 == b.1 && b.0 == c.0 && c.1 == d.1 && d.0 == a.0
}

/// A figure at its size, in points.
#[derive(Clone, Debug)]
pub(super) struct Page {
    pub(super) width: f64,
    pub(super) height: f64,
    /// In drawing order.
    pub(super) items: Vec<Item>,
    /// The dashed strokes of the lines, and whether the line was too long for dashes.
    dashed: Vec<(Stroke, bool)>,
}

impl Page {
    /// An empty page of a width.
    pub(super) fn new(width: f64) -> Self {
        Self { width, height: 0.0, items: vec![], dashed: vec![] }
    }

    /// Draws lines, each with at least two points; a line of one point is a dot.
    pub(super) fn lines(&mut self, lines: Vec<Vec<Point>>, stroke: &Stroke) {
        let (dots, lines): (Vec<_>, Vec<_>) =
            lines.into_iter().filter(|line| !line.is_empty()).partition(|line| line.len() == 1);
        let length: f64 = lines.iter().flat_map(|line| line.windows(2)).map(|pair| distance(pair[0], pair[1])).sum();
        let period: f64 = stroke.dashes.iter().sum();
        let is_solid = 0.5 * stroke.dashes.len() as f64 * length > MAX_DASHES * period;
        if !lines.is_empty() && !stroke.dashes.is_empty() {
            self.dashed.push((*stroke, is_solid));
        }
        let stroke = Stroke { dashes: if is_solid { &[] } else { stroke.dashes }, ..*stroke };
        if !lines.is_empty() {
            self.items.push(Item::Lines(lines, stroke));
        }
        self.items.extend(dots.iter().map(|dot| Item::Dot(dot[0], 0.5 * stroke.width + 0.2, stroke.color)));
    }

    /// A stroke as its lines were drawn: solid if all of them were too long for dashes.
    pub(super) fn as_drawn(&self, stroke: &Stroke) -> Stroke {
        let mut drawn = self.dashed.iter().filter(|(dashed, _)| dashed == stroke).peekable();
        let is_solid = drawn.peek().is_some() && drawn.all(|(_, is_solid)| *is_solid);
        Stroke { dashes: if is_solid { &[] } else { stroke.dashes }, ..*stroke }
    }

    pub(super) fn line(&mut self, from: Point, to: Point, stroke: &Stroke) {
        self.lines(vec![vec![from, to]], stroke);
    }

    pub(super) fn rectangle(&mut self, from: Point, to: Point, color: Color) {
        self.items.push(Item::Area(vec![from, (to.0, from.1), to, (from.0, to.1)], color));
    }

    /// Draws the mark of an alarm: a triangle below a point.
    pub(super) fn alarm(&mut self, (x, y): Point) {
        self.items.push(Item::Area(vec![(x - 3.0, y), (x + 3.0, y), (x, y + 6.0)], BLACK));
    }

    pub(super) fn text(&mut self, text: Text) {
        self.items.push(Item::Text(text));
    }
}

fn distance(a: Point, b: Point) -> f64 {
    (b.0 - a.0).hypot(b.1 - a.1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::figures::style::{AUGMENTED, CLASSICAL};

    #[test]
    fn a_line_is_dashed_unless_it_swings_too_often() {
        let dashes = |swings: f64| {
            let line = (0..8000).map(|k| 0.03 * f64::from(k)).map(|x| (x, 50.0 * (x * swings).sin())).collect();
            let mut page = Page::new(1.0);
            page.lines(vec![line], &CLASSICAL);
            assert_eq!(page.as_drawn(&AUGMENTED), AUGMENTED, "no line has it");
            match &page.items[..] {
                [Item::Lines(_, stroke)] => {
                    assert_eq!(page.as_drawn(&CLASSICAL), *stroke, "the legend's");
                    stroke.dashes.len()
                }
                other => panic!("{other:?}"),
            }
        };
        assert_eq!((dashes(0.1), dashes(5.0)), (2, 0));
    }
}
