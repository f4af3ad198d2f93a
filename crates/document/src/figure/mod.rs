//! A figure as data, independent of size, typeface and file format: `trocar-report` draws it on paper, pages with
//! `charts.js`, the Python package with matplotlib.

mod axis;
mod decimate;
mod json;
mod shade;
mod style;

use std::borrow::Cow;
use std::ops::Range;

pub use axis::{Axis, Ticks, X_TICKS, Y_TICKS, extent, quantile_extent, union};
pub use shade::Shade;
pub use style::*;

use decimate::kept;

/// In the coordinates of a pair of axes, or on paper.
pub type Point = (f64, f64);

#[derive(Clone, Debug, Default, PartialEq)]
pub struct Figure<'a> {
    pub name: String,
    pub legend: Vec<Entry>,
    /// From the top down.
    pub rows: Vec<Row<'a>>,
}

/// From left to right.
#[derive(Clone, Debug, PartialEq)]
pub struct Row<'a> {
    pub title: Option<String>,
    /// Of the axes at the width of a page, in points.
    pub height: f64,
    pub panels: Vec<Panel<'a>>,
}

impl<'a> Row<'a> {
    pub fn of(height: f64, panel: Panel<'a>) -> Self {
        Self { title: None, height, panels: vec![panel] }
    }
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Sample {
    /// The text is a title.
    Title,
    Line(Stroke),
    Dot(Stroke),
    Shade(Color),
    Alarm,
    Rupture,
}

pub type Entry = (Sample, String);

/// Over increasing x; values are multiplied by `scale`.
#[derive(Clone, Debug, PartialEq)]
pub struct Series<'a> {
    /// In the coordinate of the axis.
    pub x: Cow<'a, [f64]>,
    /// Non-finite values leave a gap.
    pub y: Cow<'a, [f64]>,
    pub scale: f64,
    pub stroke: Stroke,
}

impl<'a> Series<'a> {
    pub fn new(x: impl Into<Cow<'a, [f64]>>, y: impl Into<Cow<'a, [f64]>>, stroke: Stroke) -> Self {
        Self { x: x.into(), y: y.into(), scale: 1.0, stroke }
    }

    pub fn times(self, scale: f64) -> Self {
        Self { scale, ..self }
    }
}

/// For every panel with this time axis.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Events {
    /// Start, end and kind, in order.
    pub shades: Vec<(f64, f64, Shade)>,
    pub ruptures: Vec<f64>,
    pub alarms: Vec<f64>,
}

#[derive(Clone, Debug, PartialEq)]
pub struct Panel<'a> {
    pub x: Axis,
    pub y: Axis,
    /// Quantity and unit.
    pub x_caption: String,
    /// Quantity and unit.
    pub y_caption: String,
    pub legend: Vec<Entry>,
    pub events: Events,
    /// In axis coordinates.
    pub fills: Vec<(Vec<Point>, Color)>,
    pub series: Vec<Series<'a>>,
    /// A line with one point is a dot.
    pub curves: Vec<(Vec<Point>, Stroke)>,
    pub levels: Vec<(f64, Stroke)>,
    /// Centred at points in axis coordinates.
    pub notes: Vec<(Point, String)>,
    pub is_bare: bool,
    /// Of the chart on a page; empty if it has none.
    pub id: &'static str,
    /// Of each fill and of the remaining panel, for a page's cursor; empty without values.
    pub measurements: Vec<String>,
}

impl<'a> Panel<'a> {
    pub fn new(x: Axis, x_caption: impl Into<String>, y: Axis, y_caption: impl Into<String>) -> Self {
        Self {
            x,
            y,
            x_caption: x_caption.into(),
            y_caption: y_caption.into(),
            legend: Vec::new(),
            events: Events::default(),
            fills: Vec::new(),
            series: Vec::new(),
            curves: Vec::new(),
            levels: Vec::new(),
            notes: Vec::new(),
            is_bare: false,
            id: "",
            measurements: Vec::new(),
        }
    }

    pub fn over_time(time: Axis, y: Axis, y_caption: impl Into<String>) -> Self {
        Self::new(time, "Time (s)", y, y_caption)
    }

    /// Reduced to the extremes of intervals, which are shorter within `detailed` (s).
    pub fn samples<'t>(
        &'t self,
        series: &'t Series<'_>,
        intervals: usize,
        detailed: &[(f64, f64)],
    ) -> impl Iterator<Item = Point> + use<'t, 'a> {
        let shown = shown(&series.x, &self.x);
        let (x, y) = (&series.x[shown.clone()], &series.y[shown]);
        let rows = kept(x, y, detailed, intervals);
        rows.into_iter().map(move |row| (x[row], self.y.place(y[row] * series.scale)))
    }
}

/// One sample beyond each end is kept: lines cross the edges.
fn shown(x: &[f64], axis: &Axis) -> Range<usize> {
    let end = (x.partition_point(|&x| x <= axis.high) + 1).min(x.len());
    let start = x[..end].partition_point(|&x| x < axis.low).saturating_sub(1);
    start..end
}
