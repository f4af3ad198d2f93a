//! For pages (`charts.js`) and the Python package (matplotlib).

use serde_json::{Value as Json, json};

use super::{Axis, Color, Entry, Events, Figure, Panel, Point, Row, Sample, Stroke};
use crate::digits::{Few, Fine};

const INTERVALS: usize = 5000;

struct Writer<'w> {
    color: fn(Color) -> String,
    /// A point that is not finite is a gap.
    points: &'w mut dyn FnMut(Vec<Point>) -> Json,
    intervals: usize,
    is_detailed: bool,
    legend: &'w [Entry],
}

impl Writer<'_> {
    fn stroke(&self, stroke: &Stroke) -> Json {
        json!({ "color": (self.color)(stroke.color), "width": stroke.width, "dashes": stroke.dashes })
    }

    fn entry(&self, (sample, text): &Entry) -> Json {
        let (kind, style) = match sample {
            Sample::Title => ("title", Json::Null),
            Sample::Line(line) => ("line", self.stroke(line)),
            Sample::Dot(dot) => ("dot", self.stroke(dot)),
            Sample::Shade(shade) => ("shade", json!({ "color": (self.color)(*shade) })),
            Sample::Alarm => ("alarm", Json::Null),
            Sample::Rupture => ("rupture", Json::Null),
        };
        json!({ "kind": kind, "style": style, "text": text })
    }

    /// The only line of a panel has the name of the axis.
    fn line(&mut self, panel: &Panel<'_>, points: Vec<Point>, stroke: &Stroke) -> Json {
        let is_of = |sample: &Sample| matches!(sample, Sample::Line(of) | Sample::Dot(of) if of == stroke);
        let entry = panel.legend.iter().chain(self.legend).find(|(sample, _)| is_of(sample));
        let is_only = panel.series.len() + panel.curves.len() == 1;
        let of_axis = if is_only { panel.y_caption.split(" (").next().unwrap_or_default() } else { "" };
        let name = entry.map_or(of_axis, |(_, text)| text);
        json!({ "name": name, "points": (self.points)(points), "style": self.stroke(stroke) })
    }

    fn panel(&mut self, panel: &Panel<'_>) -> Json {
        let events = &panel.events;
        let detailed = if self.is_detailed { detailed(events) } else { vec![] };
        let mut lines: Vec<Json> = panel
            .series
            .iter()
            .map(|series| self.line(panel, panel.samples(series, self.intervals, &detailed).collect(), &series.stroke))
            .collect();
        lines.extend(panel.curves.iter().map(|(points, stroke)| self.line(panel, points.clone(), stroke)));
        let fills = panel.fills.iter().enumerate().map(|(index, (outline, color))| {
            json!({
                "points": (self.points)(outline.clone()),
                "color": (self.color)(*color),
                "text": panel.measurements.get(index).map_or("", String::as_str),
            })
        });
        let fills: Vec<Json> = fills.collect();
        let shades = events.shades.iter().map(|(from, to, shade)| json!([from, to, (self.color)(shade.color())]));
        let levels =
            panel.levels.iter().map(|(level, line)| json!({ "at": panel.y.place(*level), "style": self.stroke(line) }));
        json!({
            "id": panel.id,
            "x": axis(&panel.x, &panel.x_caption),
            "y": axis(&panel.y, &panel.y_caption),
            "legend": panel.legend.iter().map(|one| self.entry(one)).collect::<Vec<_>>(),
            "shades": shades.collect::<Vec<_>>(),
            "ruptures": events.ruptures,
            "alarms": events.alarms,
            "fills": fills,
            "outside": panel.measurements.get(panel.fills.len()),
            "lines": lines,
            "levels": levels.collect::<Vec<_>>(),
            "notes": panel.notes.iter().map(|((x, y), text)| json!([x, y, text])).collect::<Vec<_>>(),
            "is_bare": panel.is_bare,
        })
    }

    fn row(&mut self, row: &Row<'_>) -> Json {
        let panels: Vec<Json> = row.panels.iter().map(|panel| self.panel(panel)).collect();
        json!({ "title": row.title, "height": row.height, "panels": panels })
    }
}

fn axis(axis: &Axis, caption: &str) -> Json {
    json!({ "low": axis.low, "high": axis.high, "log": axis.log, "ticks": axis.all_ticks(), "caption": caption })
}

fn detailed(events: &Events) -> Vec<(f64, f64)> {
    const BEFORE_S: f64 = 0.1;
    const AFTER_S: f64 = 0.6;
    const MAX_EVENTS: usize = 200;
    let times = events.ruptures.iter().chain(&events.alarms).take(MAX_EVENTS);
    times.map(|time_s| (time_s - BEFORE_S, time_s + AFTER_S)).collect()
}

impl Figure<'_> {
    /// Positions are in axis coordinates: exponents of ten on a logarithmic axis; `null` is a gap. A line with one
    /// point is a dot; long lines keep the minima and maxima of 5000 intervals.
    pub fn description(&self) -> Json {
        let mut points = |points: Vec<Point>| {
            let (x, y): (Vec<f64>, Vec<f64>) = points.into_iter().unzip();
            json!([x, y])
        };
        self.described(Color::hex, &mut points, INTERVALS, false)
    }

    /// Theme colours, five digits per value, lines of `intervals`, and more detail around events.
    pub fn for_page(&self, intervals: usize) -> Json {
        let mut points = |points: Vec<Point>| {
            let (x, y): (Vec<Fine>, Vec<Few>) = points.into_iter().map(|(x, y)| (Fine(x), Few(y))).unzip();
            json!([x, y])
        };
        self.described(Color::css, &mut points, intervals, true)
    }

    /// [`Self::for_page`] with the points in `bytes` as little-endian 32-bit floats: a line has the index of its first
    /// x and its number of points; all x come before y.
    pub fn for_frame(&self, intervals: usize, bytes: &mut Vec<u8>) -> Json {
        let mut points = |points: Vec<Point>| {
            let start = bytes.len() / size_of::<f32>();
            bytes.reserve(2 * points.len() * size_of::<f32>());
            points.iter().for_each(|(x, _)| bytes.extend_from_slice(&(*x as f32).to_le_bytes()));
            points.iter().for_each(|(_, y)| bytes.extend_from_slice(&(*y as f32).to_le_bytes()));
            json!([start, points.len()])
        };
        self.described(Color::css, &mut points, intervals, false)
    }

    fn described(
        &self,
        color: fn(Color) -> String,
        points: &mut dyn FnMut(Vec<Point>) -> Json,
        intervals: usize,
        is_detailed: bool,
    ) -> Json {
        let mut writer = Writer { color, points, intervals, is_detailed, legend: &self.legend };
        json!({
            "name": self.name,
            "legend": self.legend.iter().map(|one| writer.entry(one)).collect::<Vec<_>>(),
            "rows": self.rows.iter().map(|row| writer.row(row)).collect::<Vec<_>>(),
        })
    }
}
