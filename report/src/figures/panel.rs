//! One pair of axes and its content.

use std::ops::Range;

use plotters::chart::ChartBuilder;
use plotters::element::{Circle, PathElement, Polygon, Rectangle};
use plotters::style::{Color, RGBAColor, ShapeStyle, TRANSPARENT};

use super::FigureError;
use super::axis::Axis;
use super::canvas::Area;
use super::dash::dashed;
use super::style::{self, ALARM, BLACK, GRID, RUPTURE, Stroke, units};
use super::thin::{Frame, Point, polylines};

/// Height of the tick labels and the caption below an axis, in pixels.
pub(super) const X_LABELS: f64 = 108.0;
const TICK: f64 = 8.0;

/// A signal over the horizontal axis; values are multiplied by `scale` (1000 for millimetres).
pub(super) struct Trace<'a> {
    pub(super) x: &'a [f64],
    pub(super) y: &'a [f64],
    pub(super) scale: f64,
    pub(super) stroke: Stroke,
}

/// Events over time, drawn in every panel with the same time axis.
#[derive(Clone, Default)]
pub(super) struct Events {
    pub(super) shades: Vec<(f64, f64, RGBAColor)>,
    pub(super) ruptures: Vec<f64>,
    pub(super) alarms: Vec<f64>,
}

/// A pair of axes with its content, in drawing order.
pub(super) struct Panel<'a> {
    pub(super) x: Axis,
    pub(super) y: Axis,
    pub(super) x_caption: &'a str,
    pub(super) y_caption: &'a str,
    pub(super) events: Events,
    /// Filled outlines, in axis coordinates.
    pub(super) fills: Vec<(Vec<Point>, RGBAColor)>,
    pub(super) traces: Vec<Trace<'a>>,
    /// Lines in axis coordinates; a line with one point is a dot.
    pub(super) curves: Vec<(Vec<Point>, Stroke)>,
    /// Horizontal lines.
    pub(super) levels: Vec<(f64, Stroke)>,
}

/// The place of a panel in its figure, in pixels.
pub(super) struct Place {
    /// Width of the labels and the caption left of the vertical axis.
    pub(super) y_labels: f64,
    /// Whether the horizontal axis of this panel has labels.
    pub(super) x_labelled: bool,
}

impl<'a> Panel<'a> {
    /// Returns empty axes over time.
    pub(super) fn over_time(time: Axis, y: Axis, y_caption: &'a str) -> Self {
        Self {
            x: time,
            y,
            x_caption: "Time (s)",
            y_caption,
            events: Events::default(),
            fills: Vec::new(),
            traces: Vec::new(),
            curves: Vec::new(),
            levels: Vec::new(),
        }
    }

    /// Draws the panel over all of `area`.
    pub(super) fn draw(&self, area: &Area<'_>, place: &Place) -> Result<(), FigureError> {
        let x_labels = if place.x_labelled { X_LABELS } else { 0.0 };
        let mut chart = ChartBuilder::on(area)
            .x_label_area_size(units(x_labels))
            .y_label_area_size(units(place.y_labels))
            .build_cartesian_2d(self.x.clone(), self.y.clone())?;
        let inner = chart.plotting_area().strip_coord_spec();
        let (width, height) = inner.dim_in_pixel();
        let frame = Frame {
            x: (self.x.low, self.x.high),
            y: (self.y.low, self.y.high),
            width: f64::from(width) / f64::from(style::UNITS_PER_PIXEL),
            height: f64::from(height) / f64::from(style::UNITS_PER_PIXEL),
        };
        self.shades(&inner, &frame)?;
        let text = style::text();
        chart
            .configure_mesh()
            .bold_line_style(Stroke::solid(GRID, 1.5).shape())
            .light_line_style(TRANSPARENT)
            .axis_style(Stroke::solid(BLACK, 2.0).shape())
            .label_style(text.clone())
            .axis_desc_style(text)
            .set_all_tick_mark_size(units(TICK))
            .x_label_formatter(&|&tick| self.x.label(tick))
            .y_label_formatter(&|&tick| self.y.label(tick))
            .x_desc(self.x_caption)
            .y_desc(self.y_caption)
            .draw()?;
        let floor = [(0, height as i32), (width as i32, height as i32)];
        inner.draw(&PathElement::new(floor, Stroke::solid(BLACK, 2.0).shape()))?;
        for (outline, color) in &self.fills {
            let outline: Vec<(i32, i32)> = outline.iter().map(|p| whole(frame.pixel(p.0, p.1))).collect();
            inner.draw(&Polygon::new(outline, color.filled()))?;
        }
        for &at in &distinct(&self.events.ruptures, &frame) {
            stroke(&inner, vec![vec![(at, 0.0), (at, frame.height)]], &RUPTURE)?;
        }
        for trace in &self.traces {
            let shown = shown(trace.x, &self.x);
            let samples = trace.x[shown.clone()].iter().zip(&trace.y[shown]);
            let placed = samples.map(|(&x, &y)| (x, self.y.place(y * trace.scale)));
            stroke(&inner, polylines(placed, &frame), &trace.stroke)?;
        }
        for (points, line) in &self.curves {
            let points = points.iter().map(|point| frame.pixel(point.0, point.1)).collect();
            stroke(&inner, vec![points], line)?;
        }
        for (level, line) in &self.levels {
            let (_, y) = frame.pixel(self.x.low, self.y.place(*level));
            stroke(&inner, vec![vec![(0.0, y), (frame.width, y)]], line)?;
        }
        for &at in &distinct(&self.events.alarms, &frame) {
            alarm_mark(&inner, (at, 0.0))?;
        }
        Ok(())
    }

    fn shades(&self, inner: &Area<'_>, frame: &Frame) -> Result<(), FigureError> {
        let mut drawn = f64::NEG_INFINITY;
        for &(from, to, color) in &self.events.shades {
            let left = frame.pixel(from, 0.0).0.round().max(0.0).max(drawn);
            let right = frame.pixel(to, 0.0).0.round().min(frame.width);
            if right > left {
                let corners = [whole((left, 0.0)), whole((right, frame.height))];
                inner.draw(&Rectangle::new(corners, color.filled()))?;
                drawn = right;
            }
        }
        Ok(())
    }
}

/// Draws the mark of an alarm: a triangle below `at`.
pub(super) fn alarm_mark(area: &Area<'_>, at: Point) -> Result<(), FigureError> {
    let (x, y) = at;
    let corners = [(x - 11.0, y), (x + 11.0, y), (x, y + 22.0)];
    let outline: Vec<(i32, i32)> = corners.into_iter().map(whole).collect();
    area.draw(&Polygon::new(outline, ALARM.color.filled()))?;
    Ok(())
}

/// Draws `lines`, in pixels of `area`.
pub(super) fn stroke(area: &Area<'_>, lines: Vec<Vec<Point>>, stroke: &Stroke) -> Result<(), FigureError> {
    let shape: ShapeStyle = stroke.shape();
    for line in dashed(lines, stroke.dashes) {
        let mut points: Vec<(i32, i32)> = line.into_iter().map(whole).collect();
        points.dedup();
        if let [point] = points[..] {
            let radius = units(stroke.width / 2.0 + 0.5);
            area.draw(&Circle::new(point, radius, stroke.color.filled()))?;
        } else {
            area.draw(&PathElement::new(points, shape))?;
        }
    }
    Ok(())
}

/// Returns the samples of the increasing column `x` on `axis`, and one beyond each end for the lines that cross the edges.
fn shown(x: &[f64], axis: &Axis) -> Range<usize> {
    let end = (x.partition_point(|&x| x <= axis.high) + 1).min(x.len());
    let start = x[..end].partition_point(|&x| x < axis.low).saturating_sub(1);
    start..end
}

/// Returns the distinct pixel columns of the events inside the frame.
fn distinct(times: &[f64], frame: &Frame) -> Vec<f64> {
    let mut columns: Vec<f64> = times
        .iter()
        .filter(|time| time.is_finite())
        .map(|&time| frame.pixel(time, 0.0).0.round())
        .filter(|column| (0.0..=frame.width).contains(column))
        .collect();
    columns.sort_by(f64::total_cmp);
    columns.dedup();
    columns
}

fn whole((x, y): Point) -> (i32, i32) {
    (units(x), units(y))
}
