//! The data of interactive charts, which `assets/charts.js` draws.

use serde::Serialize;

use crate::digits::{Few, Fine};

/// The colours of several runs or cases in one chart, by their names in the theme.
pub(super) const COLOURS: [&str; 8] = ["blue", "vermilion", "green", "black", "purple", "orange", "sky", "grey"];

/// An axis.
#[derive(Clone, Debug, Default, Serialize)]
pub(super) struct ChartAxis {
    pub(super) label: String,
    pub(super) unit: &'static str,
    pub(super) log: bool,
}

impl ChartAxis {
    pub(super) fn new(label: impl Into<String>, unit: &'static str) -> Self {
        Self { label: label.into(), unit, log: false }
    }

    pub(super) fn log(self) -> Self {
        Self { log: true, ..self }
    }
}

/// A line or points, and their style.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Series {
    pub(super) label: String,
    pub(super) colour: &'static str,
    /// Width in pixels.
    pub(super) width: f64,
    /// Dashes (on, off, on, off …) in pixels; empty for a solid line.
    pub(super) dash: &'static [u32],
    pub(super) show: bool,
    /// Whether each value holds until the next one.
    pub(super) stepped: bool,
    /// Whether the series is drawn as points.
    pub(super) scatter: bool,
    /// Whether the line continues over missing values.
    pub(super) span: bool,
    /// Whether it is an edge of a band: the upper edge, and the lower one next to it.
    pub(super) edge: bool,
}

impl Series {
    pub(super) fn line(label: impl Into<String>, colour: &'static str) -> Self {
        Self {
            label: label.into(),
            colour,
            width: 2.0,
            dash: &[],
            show: true,
            stepped: false,
            scatter: false,
            span: false,
            edge: false,
        }
    }

    /// The edges of a band around a line: the upper and the lower one.
    pub(super) fn edges(name: &str, colour: &'static str) -> [Self; 2] {
        ["+", "−"].map(|sign| Self { width: 0.5, edge: true, ..Self::line(format!("{sign} {name}"), colour) })
    }

    pub(super) fn dashed(self) -> Self {
        Self { dash: &[7, 5], ..self }
    }
}

/// The mark of an event.
#[derive(Clone, Debug, Serialize, PartialEq)]
pub(super) struct Mark {
    pub(super) at: Fine,
    /// `rupture` or `alarm`.
    pub(super) kind: &'static str,
    pub(super) label: String,
    /// What became of it, for the timeline.
    #[serde(skip)]
    pub(super) fate: String,
}

/// A shaded interval.
#[derive(Clone, Debug, Serialize)]
pub(super) struct ChartShade {
    pub(super) from: Fine,
    pub(super) to: Fine,
    /// `augmented` (frozen), `reengaging`, `insertion`, `hold` or `withdrawal`.
    pub(super) name: &'static str,
}

/// A level of the vertical axis.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Level {
    pub(super) value: Few,
}

/// The shades, marks and thresholds of a chart.
#[derive(Clone, Debug, Default, Serialize)]
pub(super) struct Extras {
    pub(super) shades: Vec<ChartShade>,
    pub(super) marks: Vec<Mark>,
    pub(super) thresholds: Vec<Level>,
}

/// Columns over their own horizontal axis.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Columns {
    pub(super) x: Vec<Fine>,
    pub(super) y: Vec<Vec<Few>>,
}

impl Columns {
    pub(super) fn new(x: impl IntoIterator<Item = f64>, y: Vec<Vec<f64>>) -> Self {
        let few = |column: Vec<f64>| column.into_iter().map(Few).collect();
        Self { x: x.into_iter().map(Fine).collect(), y: y.into_iter().map(few).collect() }
    }

    /// Returns the selected rows of columns, multiplied by a factor.
    pub(super) fn rows(x: &[f64], columns: &[&[f64]], rows: &[usize], factor: f64) -> Self {
        let of = |column: &&[f64]| rows.iter().map(|row| factor * column[*row]).collect();
        Self::new(rows.iter().map(|row| x[*row]), columns.iter().map(of).collect())
    }
}

/// A chart. The series are in the order of the columns.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Chart {
    pub(super) title: String,
    /// Text alternative for screen readers.
    pub(super) alt: String,
    pub(super) height: u32,
    #[serde(rename = "markLabels")]
    pub(super) mark_labels: bool,
    pub(super) x: ChartAxis,
    pub(super) y: ChartAxis,
    /// Values that the vertical axis always includes.
    pub(super) includes: Vec<Few>,
    /// Fixed limits of the vertical axis, if any.
    pub(super) range: Option<[Few; 2]>,
    pub(super) series: Vec<Series>,
    pub(super) columns: Vec<Columns>,
    pub(super) extras: Extras,
}

impl Chart {
    pub(super) fn new(title: impl Into<String>, x: ChartAxis, y: ChartAxis) -> Self {
        Self {
            title: title.into(),
            alt: String::new(),
            height: 240,
            mark_labels: false,
            x,
            y,
            includes: vec![],
            range: None,
            series: vec![],
            columns: vec![],
            extras: Extras::default(),
        }
    }

    /// Returns the same chart with a text alternative from its title, axes and lines.
    pub(super) fn described(mut self) -> Self {
        let names: Vec<&str> = self.series.iter().map(|series| series.label.as_str()).collect();
        let ends = |ends: (f64, f64), x: &Fine| (ends.0.min(x.0), ends.1.max(x.0));
        let xs = self.columns.iter().flat_map(|columns| &columns.x);
        let (from, to) = xs.fold((f64::INFINITY, f64::NEG_INFINITY), ends);
        let unit = |axis: &ChartAxis| if axis.unit.is_empty() { String::new() } else { format!(" in {}", axis.unit) };
        let mut alt = format!("{}. {}{} against ", self.title, self.y.label, unit(&self.y));
        alt.push_str(&format!("{}{}", self.x.label, unit(&self.x)));
        if from <= to {
            let shown = crate::number::significant;
            alt.push_str(&format!(" from {} to {}", shown(from), shown(to)));
        }
        self.alt = format!("{alt}: {}.", names.join(", "));
        self
    }
}
