//! One pair of axes and its content.

use std::borrow::Cow;
use std::ops::Range;

use super::axis::{Axis, Ticks};
use super::fonts;
use super::legend::Entry;
use super::lines::{Frame, polylines};
use super::page::{Anchor, Item, LINE, Page, Point, Text, centred};
use super::shade::Shade;
use super::style::{Color, FRAME, MESH, RUPTURE, Stroke, TEXT};
use crate::decimate::kept;

/// Height of the tick labels below an axis.
const TICK_LABELS: f64 = 8.0;
const TICK: f64 = 2.5;
/// Gap between a tick and its label, and between labels and captions.
const GAP: f64 = 2.0;
/// Free width right of an axis, for the half of the last label.
pub(super) const RIGHT: f64 = 10.0;
/// Minimum width left of an axis, for the half of the first label.
const MIN_LEFT: f64 = 10.0;
/// Minimum distance of the centres of labels along a vertical axis, and of the edges of labels along a horizontal one.
const MIN_RISE: f64 = 11.0;
const MIN_GAP: f64 = 5.0;
/// Width of an interval of which a line keeps the minimum and the maximum.
const INTERVAL: f64 = 0.4;

/// A signal over the horizontal axis; values are multiplied by `scale` (1000 for millimetres).
pub(super) struct Trace<'a> {
    pub(super) x: Cow<'a, [f64]>,
    pub(super) y: Cow<'a, [f64]>,
    pub(super) scale: f64,
    pub(super) stroke: Stroke,
}

impl<'a> Trace<'a> {
    pub(super) fn new(x: impl Into<Cow<'a, [f64]>>, y: impl Into<Cow<'a, [f64]>>, stroke: Stroke) -> Self {
        Self { x: x.into(), y: y.into(), scale: 1.0, stroke }
    }

    pub(super) fn times(self, scale: f64) -> Self {
        Self { scale, ..self }
    }
}

/// Events over time, drawn in every panel with the same time axis.
#[derive(Clone, Default)]
pub(super) struct Events {
    pub(super) shades: Vec<(f64, f64, Shade)>,
    pub(super) ruptures: Vec<f64>,
    pub(super) alarms: Vec<f64>,
}

/// A pair of axes with its content, in drawing order.
pub(super) struct Panel<'a> {
    pub(super) x: Axis,
    pub(super) y: Axis,
    pub(super) x_caption: String,
    pub(super) y_caption: String,
    /// Drawn above the axes.
    pub(super) legend: Vec<Entry>,
    pub(super) events: Events,
    /// Filled outlines, in axis coordinates.
    pub(super) fills: Vec<(Vec<Point>, Color)>,
    pub(super) traces: Vec<Trace<'a>>,
    /// Lines in axis coordinates; a line with one point is a dot.
    pub(super) curves: Vec<(Vec<Point>, Stroke)>,
    /// Horizontal lines.
    pub(super) levels: Vec<(f64, Stroke)>,
    /// Texts around places in axis coordinates.
    pub(super) notes: Vec<(Point, String)>,
    /// Whether the axes are invisible.
    pub(super) is_bare: bool,
    /// Name of the chart on a page, if it has one.
    pub(super) id: &'static str,
    /// The value of each fill and of what is outside, for the cursor of a page; empty without values.
    pub(super) readings: Vec<String>,
}

/// The place of a panel's axes on the page, and its labels.
pub(super) struct Place {
    pub(super) left: f64,
    pub(super) top: f64,
    pub(super) width: f64,
    pub(super) height: f64,
    /// Left edge of the caption.
    pub(super) edge: f64,
    /// Whether the horizontal axis has labels.
    pub(super) x_labelled: bool,
}

impl<'a> Panel<'a> {
    /// Returns empty axes.
    pub(super) fn new(x: Axis, x_caption: impl Into<String>, y: Axis, y_caption: impl Into<String>) -> Self {
        Self {
            x,
            y,
            x_caption: x_caption.into(),
            y_caption: y_caption.into(),
            legend: Vec::new(),
            events: Events::default(),
            fills: Vec::new(),
            traces: Vec::new(),
            curves: Vec::new(),
            levels: Vec::new(),
            notes: Vec::new(),
            is_bare: false,
            id: "",
            readings: Vec::new(),
        }
    }

    /// Returns empty axes over time.
    pub(super) fn over_time(time: Axis, y: Axis, y_caption: impl Into<String>) -> Self {
        Self::new(time, "Time (s)", y, y_caption)
    }

    /// Returns the width of the labels and the caption left of axes of a height.
    pub(super) fn label_width(&self, height: f64) -> f64 {
        let ticks = self.y_ticks(height);
        let widest = ticks.iter().map(|(_, label)| fonts::width(label, TEXT, false)).fold(0.0, f64::max);
        let labels = if ticks.is_empty() { 0.0 } else { TICK + GAP + widest };
        let caption = self.y_caption_lines(height).len() as f64 * LINE;
        (labels + caption + if caption > 0.0 { GAP } else { 0.0 }).max(MIN_LEFT)
    }

    /// Returns the height of the labels and the caption below axes of a width.
    pub(super) fn label_height(&self, width: f64) -> f64 {
        TICK + GAP + TICK_LABELS + LINE * self.x_caption_lines(width).len() as f64
    }

    fn y_caption_lines(&self, height: f64) -> Vec<String> {
        fonts::lines(&self.y_caption, TEXT, false, height)
    }

    fn x_caption_lines(&self, width: f64) -> Vec<String> {
        fonts::lines(&self.x_caption, TEXT, false, width)
    }

    fn y_ticks(&self, height: f64) -> Ticks {
        let per_unit = height / (self.y.high - self.y.low);
        self.y.ticks(|ticks| ticks.windows(2).all(|pair| (pair[1].0 - pair[0].0) * per_unit >= MIN_RISE))
    }

    fn x_ticks(&self, width: f64) -> Ticks {
        let place = |tick: f64| (tick - self.x.low) / (self.x.high - self.x.low) * width;
        let half = |label: &str| 0.5 * fonts::width(label, TEXT, false);
        self.x.ticks(|ticks| {
            let apart = |pair: &[(f64, String)]| {
                place(pair[1].0) - half(&pair[1].1) >= place(pair[0].0) + half(&pair[0].1) + MIN_GAP
            };
            let is_inside = |(tick, label): &(f64, String)| place(*tick) + half(label) <= width + RIGHT;
            ticks.windows(2).all(apart) && ticks.iter().all(is_inside)
        })
    }

    /// Draws the panel.
    pub(super) fn draw(&self, page: &mut Page, at: &Place) {
        let Place { left, top, width, height, .. } = *at;
        let frame = Frame { x: (self.x.low, self.x.high), y: (self.y.low, self.y.high), width, height };
        let shift = |(x, y): Point| (left + x, top + y);
        let (x_ticks, y_ticks) = (self.x_ticks(width), self.y_ticks(height));
        let (right, bottom) = (left + width, top + height);
        self.shades(page, &frame, shift);
        let vertical = x_ticks.iter().map(|(tick, _)| frame.place(*tick, self.y.low).0 + left);
        page.lines(vertical.map(|x| vec![(x, top), (x, bottom)]).collect(), &MESH);
        let horizontal = y_ticks.iter().map(|(tick, _)| frame.place(self.x.low, *tick).1 + top);
        page.lines(horizontal.map(|y| vec![(left, y), (right, y)]).collect(), &MESH);
        for (outline, color) in &self.fills {
            let clip = |(x, y): Point| shift((x.clamp(0.0, width), y.clamp(0.0, height)));
            let outline = outline.iter().map(|point| clip(frame.place(point.0, point.1))).collect();
            page.items.push(Item::Area(outline, *color));
        }
        for at in distinct(&self.events.ruptures, &frame) {
            page.line((left + at, top), (left + at, bottom), &RUPTURE);
        }
        for trace in &self.traces {
            let lines = polylines(self.samples(trace, (width / INTERVAL) as usize, &[]), &frame);
            let lines = lines.into_iter().map(|line| line.into_iter().map(shift).collect()).collect();
            page.lines(lines, &trace.stroke);
        }
        for (points, line) in &self.curves {
            let lines = polylines(points.iter().copied(), &frame);
            page.lines(lines.into_iter().map(|line| line.into_iter().map(shift).collect()).collect(), line);
        }
        for (level, line) in &self.levels {
            let (_, y) = shift(frame.place(self.x.low, self.y.place(*level)));
            if (top..=bottom).contains(&y) {
                page.line((left, y), (right, y), line);
            }
        }
        for at in distinct(&self.events.alarms, &frame) {
            page.alarm((left + at, top));
        }
        for ((x, y), note) in &self.notes {
            let (x, y) = shift(frame.place(*x, *y));
            page.text(Text::new(note, (x, centred(y)), Anchor::Middle));
        }
        if self.is_bare {
            return;
        }
        page.lines(vec![vec![(left, top), (left, bottom), (right, bottom)]], &FRAME);
        self.labels(page, at, (&x_ticks, &y_ticks), &frame);
    }

    fn labels(&self, page: &mut Page, at: &Place, (x_ticks, y_ticks): (&Ticks, &Ticks), frame: &Frame) {
        let Place { left, top, width, height, .. } = *at;
        let bottom = top + height;
        for (tick, label) in y_ticks {
            let y = top + frame.place(self.x.low, *tick).1;
            page.line((left - TICK, y), (left, y), &FRAME);
            page.text(Text::new(label, (left - TICK - GAP, centred(y)), Anchor::End));
        }
        for (index, line) in self.y_caption_lines(height).into_iter().enumerate() {
            let x = at.edge + LINE * (index as f64 + 0.76);
            let text = Text::new(line, (x, top + 0.5 * height), Anchor::Middle);
            page.text(Text { is_upright: true, ..text });
        }
        let mut baseline = bottom + TICK + GAP + 0.76 * TEXT;
        for (tick, label) in x_ticks {
            let x = left + frame.place(*tick, self.y.low).0;
            page.line((x, bottom), (x, bottom + TICK), &FRAME);
            if at.x_labelled {
                page.text(Text::new(label, (x, baseline), Anchor::Middle));
            }
        }
        for line in self.x_caption_lines(width).into_iter().filter(|_| at.x_labelled) {
            baseline += LINE;
            page.text(Text::new(line, (left + 0.5 * width, baseline), Anchor::Middle));
        }
    }

    /// Returns the visible samples of a trace, in axis coordinates, reduced to intervals, and to shorter ones within `detailed` (s).
    pub(super) fn samples<'t>(
        &'t self,
        trace: &'t Trace<'_>,
        intervals: usize,
        detailed: &[(f64, f64)],
    ) -> impl Iterator<Item = Point> + use<'t, 'a> {
        let shown = shown(&trace.x, &self.x);
        let (x, y) = (&trace.x[shown.clone()], &trace.y[shown]);
        let rows = kept(x, y, detailed, intervals);
        rows.into_iter().map(move |row| (x[row], self.y.place(y[row] * trace.scale)))
    }

    fn shades(&self, page: &mut Page, frame: &Frame, shift: impl Fn(Point) -> Point) {
        let mut drawn = f64::NEG_INFINITY;
        for &(from, to, shade) in &self.events.shades {
            let left = frame.place(from, 0.0).0.max(0.0).max(drawn);
            let right = frame.place(to, 0.0).0.min(frame.width);
            if right > left {
                page.rectangle(shift((left, 0.0)), shift((right, frame.height)), shade.color());
                drawn = right;
            }
        }
    }
}

/// Returns the samples of the increasing column `x` on `axis`, and one beyond each end for the lines that cross the edges.
fn shown(x: &[f64], axis: &Axis) -> Range<usize> {
    let end = (x.partition_point(|&x| x <= axis.high) + 1).min(x.len());
    let start = x[..end].partition_point(|&x| x < axis.low).saturating_sub(1);
    start..end
}

/// Returns the distinct places of the events inside the frame.
fn distinct(times: &[f64], frame: &Frame) -> Vec<f64> {
    let mut places: Vec<f64> = times
        .iter()
        .filter(|time| time.is_finite())
        .map(|&time| (4.0 * frame.place(time, 0.0).0).round() / 4.0)
        .filter(|place| (0.0..=frame.width).contains(place))
        .collect();
    places.sort_by(f64::total_cmp);
    places.dedup();
    places
}
