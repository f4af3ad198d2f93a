//! One pair of axes and its content, in the coordinates of plotters.

use std::ops::Range;

use plotters::coord::cartesian::Cartesian2d;
use plotters::coord::ranged1d::{KeyPointHint, NoDefaultFormatting, Ranged};
use plotters::coord::types::RangedCoordf64;
use plotters::drawing::DrawingArea;
use plotters::prelude::DrawingBackend;
use plotters_backend::BackendCoord;

use super::clip::visible;
use super::fonts;
use super::pen::{Drawn, LINE, Pen, TEXT, Text, fill, shape};
use trocar_document::animation::Anchor;
use trocar_document::figure::{Axis, FRAME, MESH, Panel, Point, RUPTURE, Ticks};

const TICK_LABELS: f64 = 8.0;
const TICK: f64 = 2.5;
const GAP: f64 = 2.0;
/// Free width right of an axis, for half of the last label.
pub(super) const RIGHT: f64 = 10.0;
/// Minimum width left of an axis, for half of the first label.
const MIN_LEFT: f64 = 10.0;
/// Minimum distance between label centres along a vertical axis, and between label edges along a horizontal one.
const MIN_RISE: f64 = 11.0;
const MIN_GAP: f64 = 5.0;
const MIN_CAPTIONED: f64 = 24.0;
/// Width of an interval. A line keeps its minimum and maximum in each interval.
const INTERVAL: f64 = 0.4;

pub(super) struct Place {
    pub(super) left: f64,
    pub(super) top: f64,
    pub(super) width: f64,
    pub(super) height: f64,
    pub(super) edge: f64,
    pub(super) x_labelled: bool,
}

struct Scale {
    range: RangedCoordf64,
    ticks: Ticks,
}

impl Scale {
    fn new(axis: &Axis, ticks: Ticks) -> Self {
        Self { range: (axis.low..axis.high).into(), ticks }
    }
}

impl Ranged for Scale {
    type FormatOption = NoDefaultFormatting;
    type ValueType = f64;

    fn map(&self, place: &f64, limit: (i32, i32)) -> i32 {
        self.range.map(place, limit)
    }

    fn key_points<Hint: KeyPointHint>(&self, _: Hint) -> Vec<f64> {
        self.ticks.iter().map(|(tick, _)| *tick).collect()
    }

    fn range(&self) -> Range<f64> {
        self.range.range()
    }
}

pub(super) fn label_width(panel: &Panel<'_>, height: f64) -> f64 {
    let ticks = y_ticks(&panel.y, height);
    let widest = ticks.iter().map(|(_, label)| fonts::width(label, TEXT, false)).fold(0.0, f64::max);
    let labels = if ticks.is_empty() { 0.0 } else { TICK + GAP + widest };
    let caption = caption(panel, height).len() as f64 * LINE;
    (labels + caption + if caption > 0.0 { GAP } else { 0.0 }).max(MIN_LEFT)
}

/// The lines of the caption left of axes; empty if the axes are too low for a word.
fn caption(panel: &Panel<'_>, height: f64) -> Vec<String> {
    if height < MIN_CAPTIONED { vec![] } else { fonts::lines(&panel.y_caption, TEXT, false, height) }
}

pub(super) fn label_height(panel: &Panel<'_>, width: f64) -> f64 {
    TICK + GAP + TICK_LABELS + LINE * fonts::lines(&panel.x_caption, TEXT, false, width).len() as f64
}

fn share(axis: &Axis, place: f64) -> f64 {
    (place - axis.low) / (axis.high - axis.low)
}

fn y_ticks(axis: &Axis, height: f64) -> Ticks {
    let rise = |pair: &[(f64, String)]| (share(axis, pair[1].0) - share(axis, pair[0].0)) * height;
    axis.ticks(|ticks| ticks.windows(2).all(|pair| rise(pair) >= MIN_RISE))
}

fn x_ticks(axis: &Axis, width: f64) -> Ticks {
    let at = |tick: f64| share(axis, tick) * width;
    let half = |label: &str| 0.5 * fonts::width(label, TEXT, false);
    axis.ticks(|ticks| {
        let apart =
            |pair: &[(f64, String)]| at(pair[1].0) - half(&pair[1].1) >= at(pair[0].0) + half(&pair[0].1) + MIN_GAP;
        let is_inside = |(tick, label): &(f64, String)| at(*tick) + half(label) <= width + RIGHT;
        ticks.windows(2).all(apart) && ticks.iter().all(is_inside)
    })
}

pub(super) struct Axes<'a, B: DrawingBackend> {
    pen: &'a Pen<'a, B>,
    panel: &'a Panel<'a>,
    at: &'a Place,
    area: DrawingArea<B, Cartesian2d<Scale, Scale>>,
}

impl<'a, B: DrawingBackend> Axes<'a, B> {
    pub(super) fn new(pen: &'a Pen<'a, B>, panel: &'a Panel<'a>, at: &'a Place) -> Self {
        let [left, top, width, height] = [at.left, at.top, at.width, at.height].map(|length| pen.units(length));
        let inner = pen.area.clone().shrink((left, top), (width, height));
        let (across, down) = inner.get_pixel_range();
        let x = Scale::new(&panel.x, x_ticks(&panel.x, at.width));
        let y = Scale::new(&panel.y, y_ticks(&panel.y, at.height));
        let area = inner.apply_coord_spec(Cartesian2d::new(x, y, (across, down.end..down.start)));
        Self { pen, panel, at, area }
    }

    pub(super) fn draw(&self) -> Drawn<B> {
        let Panel { x, y, .. } = self.panel;
        self.shades()?;
        let mesh = shape(MESH.color).stroke_width(self.pen.units(MESH.width).unsigned_abs());
        self.area.draw_mesh(|backend, line| line.draw(backend, &mesh), 0, 0)?;
        for (outline, color) in &self.panel.fills {
            let outline: Vec<Point> = outline.iter().map(|at| (x.within(at.0), y.within(at.1))).collect();
            fill(&self.area, &outline, *color)?;
        }
        for at in self.times(&self.panel.events.ruptures) {
            self.pen.strokes(vec![vec![(at, self.top()), (at, self.bottom())]], &RUPTURE)?;
        }
        for series in &self.panel.series {
            let samples = self.panel.samples(series, (self.at.width / INTERVAL) as usize, &[]);
            self.pen.strokes(self.lines(samples), &series.stroke)?;
        }
        for (points, stroke) in &self.panel.curves {
            self.pen.strokes(self.lines(points.iter().copied()), stroke)?;
        }
        for (level, stroke) in &self.panel.levels {
            let level = y.place(*level);
            self.pen.strokes(self.lines([(x.low, level), (x.high, level)]), stroke)?;
        }
        for at in self.times(&self.panel.events.alarms) {
            self.pen.alarm((at, self.top()))?;
        }
        for (at, note) in &self.panel.notes {
            self.pen.text_at(&Text::new(note, (0.0, 0.0), Anchor::Middle), self.area.map_coordinate(at))?;
        }
        if self.panel.is_bare { Ok(()) } else { self.labels() }
    }

    fn top(&self) -> i32 {
        self.area.get_y_axis_pixel_range().start
    }

    fn bottom(&self) -> i32 {
        self.area.get_y_axis_pixel_range().end
    }

    fn lines(&self, samples: impl IntoIterator<Item = Point>) -> Vec<Vec<BackendCoord>> {
        let lines = visible(samples, &self.panel.x, &self.panel.y).into_iter();
        lines.map(|line| line.iter().map(|at| self.area.map_coordinate(at)).collect()).collect()
    }

    /// The unique positions of the events within the axes, in quarter points.
    fn times(&self, times: &[f64]) -> Vec<i32> {
        let Panel { x, y, .. } = self.panel;
        let quarter = self.pen.units(0.25);
        let inside = times.iter().filter(|time| (x.low..=x.high).contains(*time));
        let mut places: Vec<i32> = inside.map(|time| self.area.map_coordinate(&(*time, y.low)).0).collect();
        places.sort_unstable();
        places.dedup_by_key(|place| *place / quarter);
        places
    }

    fn shades(&self) -> Drawn<B> {
        let Panel { x, y, .. } = self.panel;
        let mut drawn = x.low;
        for &(from, to, shade) in &self.panel.events.shades {
            let (left, right) = (x.within(from).max(drawn), x.within(to));
            if right > left {
                fill(&self.area, &[(left, y.high), (right, y.high), (right, y.low), (left, y.low)], shade.color())?;
                drawn = right;
            }
        }
        Ok(())
    }

    fn labels(&self) -> Drawn<B> {
        let Place { left, top, width, height, edge, x_labelled } = *self.at;
        let (pen, panel) = (self.pen, self.panel);
        let across = self.area.get_x_axis_pixel_range();
        let (low, high) = ((across.start, self.bottom()), (across.end, self.bottom()));
        pen.strokes(vec![vec![(low.0, self.top()), low, high]], &FRAME)?;
        let [tick_length, gap] = [TICK, GAP].map(|length| pen.units(length));
        for (tick, label) in &self.area.as_coord_spec().y_spec().ticks {
            let (x, y) = self.area.map_coordinate(&(panel.x.low, *tick));
            pen.strokes(vec![vec![(x - tick_length, y), (x, y)]], &FRAME)?;
            pen.text_at(&Text::new(label, (0.0, 0.0), Anchor::End), (x - tick_length - gap, y))?;
        }
        for (index, line) in caption(panel, height).into_iter().enumerate() {
            let at = (edge + LINE * (index as f64 + 0.76) - 0.26 * TEXT, top + 0.5 * height);
            pen.text(&Text { is_upright: true, ..Text::new(line, at, Anchor::Middle) })?;
        }
        let middle = TICK + GAP + 0.5 * TEXT;
        for (tick, label) in &self.area.as_coord_spec().x_spec().ticks {
            let (x, y) = self.area.map_coordinate(&(*tick, panel.y.low));
            pen.strokes(vec![vec![(x, y), (x, y + tick_length)]], &FRAME)?;
            if x_labelled {
                pen.text_at(&Text::new(label, (0.0, 0.0), Anchor::Middle), (x, y + pen.units(middle)))?;
            }
        }
        let captions = fonts::lines(&panel.x_caption, TEXT, false, width);
        for (index, line) in captions.into_iter().enumerate().filter(|_| x_labelled) {
            let down = middle + LINE * (index as f64 + 1.0);
            pen.text(&Text::new(line, (left + 0.5 * width, top + height + down), Anchor::Middle))?;
        }
        Ok(())
    }
}
