use schemars::JsonSchema;
use serde::Serialize;

use super::NoiseCheck;
use trocar_document::Cell;
use trocar_metrics::{Better, Declaration, Metrics, RunMetric, Shown, Unit};

/// One metric, with one value per scenario.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Row {
    /// Key, for example `rupture_1_detection_delay_s`.
    pub metric: String,
    /// Label in tables, for example `rupture 1: detection delay`.
    pub label: String,
    /// Declaration of the metric.
    #[serde(skip)]
    pub declaration: &'static Declaration,
    /// Number of the rupture, from 1; 1 for other metrics.
    #[serde(skip)]
    pub number: usize,
    /// Unit.
    pub unit: Unit,
    /// The better direction.
    pub better: Better,
    /// Values in SI units; `None` if undefined.
    pub values: Vec<Option<f64>>,
}

impl Row {
    fn new(declaration: &'static Declaration, number: usize, values: Vec<Option<f64>>) -> Self {
        let &Declaration { unit, better, .. } = declaration;
        let (metric, label) = (declaration.key(number), declaration.full_label(number));
        Self { metric, label, declaration, number, unit, better, values }
    }

    fn of(metric: RunMetric, runs: &[&Metrics]) -> Self {
        let values = runs.iter().map(|metrics| metric.read(metrics)).collect();
        Self::new(metric.declaration(), metric.number(), values)
    }

    pub fn cells(&self) -> Vec<Cell> {
        let mut cells = vec![Cell::from(&*self.label)];
        cells.extend(self.values.iter().map(|value| Cell::of(*value, self.unit)));
        if let [first, second] = self.values[..] {
            cells.push(change(self, first, second).into());
        }
        cells
    }

    fn is_shown(&self, shown: Shown) -> bool {
        match shown {
            Shown::Main | Shown::Always => true,
            Shown::First | Shown::MainWhereDefined | Shown::WhereDefined => self.values.iter().any(Option::is_some),
            // Omits rows without effect.
            Shown::WhereNonZero => self.values.iter().flatten().any(|value| *value != 0.0),
            Shown::Never => false,
        }
    }
}

const VANISHING_SHARE: f64 = 0.01;

/// Empty for counts, metrics with a varying sign, undefined values, and a first value near 0.
fn change(row: &Row, first: Option<f64>, second: Option<f64>) -> String {
    let (Some(first), Some(second)) = (first, second) else { return String::new() };
    let has_meaning = row.unit != Unit::Count && !row.declaration.is_signed && second >= 0.0;
    if !has_meaning || first < 1e-9 || first < VANISHING_SHARE * second {
        return String::new();
    }
    let percent = 100.0 * (second / first - 1.0);
    if second == 0.0 {
        "-100 %".into()
    } else if percent < -99.9 {
        "below -99.9 %".into()
    } else if percent.abs() < 0.05 {
        "0 %".into()
    } else {
        format!("{percent:+.1} %")
    }
}

pub fn rows(runs: &[&Metrics], noise: &[NoiseCheck]) -> Vec<Row> {
    let ruptures = runs.iter().map(|metrics| metrics.ruptures.len()).max().unwrap_or(0);
    let is_first = |metric: &RunMetric| metric.declaration().shown == Shown::First;
    let (first, others): (Vec<_>, Vec<_>) = RunMetric::of_whole_run().partition(is_first);
    let metrics = first.into_iter().chain((1..=ruptures).flat_map(RunMetric::of_rupture)).chain(others);
    let shown = metrics.filter_map(|metric| {
        let row = Row::of(metric, runs);
        row.is_shown(metric.declaration().shown).then_some(row)
    });
    let in_noise = NoiseCheck::METRICS.iter().filter(|_| !noise.is_empty());
    let in_noise = in_noise.map(|metric| Row::new(&metric.declaration, 1, noise.iter().map(metric.read).collect()));
    shown.chain(in_noise).collect()
}
