//! A figure as data, independent of size, typeface and file format.
//!
//! `trocar-report` draws it on paper, pages draw it with `charts.js`, and the Python package with matplotlib.

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

/// A point in the coordinates of a pair of axes, or on paper.
pub type Point = (f64, f64);

/// A figure.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Figure<'a> {
    /// Name of the run, the title of the figure.
    pub name: String,
    /// The legend of all panels.
    pub legend: Vec<Entry>,
    /// The panels, from the top down.
    pub rows: Vec<Row<'a>>,
}

/// One row of panels, from left to right.
#[derive(Clone, Debug, PartialEq)]
pub struct Row<'a> {
    /// The title above the row.
    pub title: Option<String>,
    /// Height of the axes at the width of a page, in points.
    pub height: f64,
    /// The panels.
    pub panels: Vec<Panel<'a>>,
}

impl<'a> Row<'a> {
    /// A row of one panel without a title.
    #[must_use]
    pub fn of(height: f64, panel: Panel<'a>) -> Self {
        Self { title: None, height, panels: vec![panel] }
    }
}

/// The sample before the text of a legend entry.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Sample {
    /// No sample: the text is a title.
    Title,
    /// A line.
    Line(Stroke),
    /// A dot.
    Dot(Stroke),
    /// A filled area.
    Shade(Color),
    /// The mark of an alarm.
    Alarm,
    /// The mark of a rupture.
    Rupture,
}

/// One entry of a legend.
pub type Entry = (Sample, String);

/// A signal over increasing x. Values are multiplied by `scale` (1000 for millimetres).
#[derive(Clone, Debug, PartialEq)]
pub struct Series<'a> {
    /// Positions on the horizontal axis, in its coordinate.
    pub x: Cow<'a, [f64]>,
    /// Values. A value that is not finite leaves a gap.
    pub y: Cow<'a, [f64]>,
    /// Factor of the values.
    pub scale: f64,
    /// Style of the line.
    pub stroke: Stroke,
}

impl<'a> Series<'a> {
    /// A series with a scale of 1.
    pub fn new(x: impl Into<Cow<'a, [f64]>>, y: impl Into<Cow<'a, [f64]>>, stroke: Stroke) -> Self {
        Self { x: x.into(), y: y.into(), scale: 1.0, stroke }
    }

    /// Sets the scale.
    #[must_use]
    pub fn times(self, scale: f64) -> Self {
        Self { scale, ..self }
    }
}

/// Events over time, drawn in every panel with this time axis.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Events {
    /// Start, end and kind of each shaded interval, in order.
    pub shades: Vec<(f64, f64, Shade)>,
    /// Times of the ruptures.
    pub ruptures: Vec<f64>,
    /// Times of the alarms.
    pub alarms: Vec<f64>,
}

/// A pair of axes with its content, in drawing order.
#[derive(Clone, Debug, PartialEq)]
pub struct Panel<'a> {
    /// The horizontal axis.
    pub x: Axis,
    /// The vertical axis.
    pub y: Axis,
    /// Quantity and unit of the horizontal axis.
    pub x_caption: String,
    /// Quantity and unit of the vertical axis.
    pub y_caption: String,
    /// The legend above the axes.
    pub legend: Vec<Entry>,
    /// Events.
    pub events: Events,
    /// Filled outlines in axis coordinates.
    pub fills: Vec<(Vec<Point>, Color)>,
    /// Signals.
    pub series: Vec<Series<'a>>,
    /// Lines in axis coordinates; a line with one point is a dot.
    pub curves: Vec<(Vec<Point>, Stroke)>,
    /// The values of horizontal lines.
    pub levels: Vec<(f64, Stroke)>,
    /// Texts centred at points in axis coordinates.
    pub notes: Vec<(Point, String)>,
    /// True if the axes are invisible.
    pub is_bare: bool,
    /// Identifier of the chart on a page; empty if it has none.
    pub id: &'static str,
    /// The value of each fill and of the remaining panel, for the cursor of a page; empty without values.
    pub measurements: Vec<String>,
}

impl<'a> Panel<'a> {
    /// Returns empty axes.
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

    /// Returns empty axes over time.
    pub fn over_time(time: Axis, y: Axis, y_caption: impl Into<String>) -> Self {
        Self::new(time, "Time (s)", y, y_caption)
    }

    /// The visible samples of a series in axis coordinates, reduced to the extremes of intervals, which are shorter
    /// within `detailed` (s).
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

/// The samples of the increasing column `x` within `axis`, and one beyond each end for lines that cross the edges.
fn shown(x: &[f64], axis: &Axis) -> Range<usize> {
    let end = (x.partition_point(|&x| x <= axis.high) + 1).min(x.len());
    let start = x[..end].partition_point(|&x| x < axis.low).saturating_sub(1);
    start..end
}
