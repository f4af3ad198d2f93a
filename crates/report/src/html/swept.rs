//! The page of a sweep.

use super::bars::influences;
use super::page::{Block, Drawn, HtmlError, Page, Row, Section, warned};
use crate::figures::{self, CasesView};
use crate::sweep::{SUMMARY_HEADING, heading, heat_figure, summary_row};
use serde_json::Value as Json;
use trocar_document::readable;
use trocar_scenario::Value;
use trocar_studies::sweep::{Axis, Column, Design, Findings, Levels, Rows, SweepError};

/// Maximum number of drawn cases.
const MAX_CASES: u64 = 2_000;

/// Maximum number of charts of a metric over an axis.
const MAX_CHARTS: usize = 16;

/// Number of classes for medians over an axis that has no levels or too many.
const CLASSES: usize = 20;

/// A complete sweep.
#[derive(Clone, Copy, Debug)]
pub struct SweepPage<'a> {
    /// The design of the sweep.
    pub design: &'a Design,
    /// The findings.
    pub findings: &'a Findings,
    /// The drawn cases.
    pub cases: &'a DrawnCases,
    /// All inputs of the sweep, as TOML.
    pub canonical: &'a str,
    /// The command that reproduces it.
    pub line: &'a str,
}

/// The values of the axes and the metrics in focus, for the drawn cases.
#[derive(Clone, Debug)]
pub struct DrawnCases {
    /// Values by axis and case.
    axes: Vec<Vec<f64>>,
    /// Values by metric in focus and case.
    metrics: Vec<Vec<f64>>,
    cases: u64,
}

/// Returns the page of a sweep.
///
/// # Errors
/// [`HtmlError`].
pub fn sweep_html(page: &SweepPage<'_>) -> Result<String, HtmlError> {
    let SweepPage { design, findings, cases: drawing, .. } = *page;
    let mut drawn = Drawn::default();
    let maps = findings.heat_maps.iter().map(|map| Ok(heat_figure(design, map)?.for_page(0)));
    drawn.figures.insert("maps", maps.collect::<Result<_, HtmlError>>()?);
    drawn.figures.insert("axes", charts(design, drawing));
    let mut sections = vec![metrics(design, findings)];
    if !design.axes.is_empty() {
        let about = "The first-order Sobol index is the share of the metric's variance that the axis explains alone. The standardised \
                     rank regression coefficient gives the direction of the influence, and R² the quality of the rank \
                     regression. The remaining variance comes from noise and from interactions of axes. Axes that vary together (correlations) \
                     share their influence: the index of each includes that of the others.";
        let rows = influences(design, findings);
        let blocks = vec![Block::text(about), Block::Influences { caption: "Influence of each axis".into(), rows }];
        sections.push(Section { id: "influences", title: "Influences", blocks });
    }
    if !findings.heat_maps.is_empty() {
        sections.push(Section { id: "maps", title: "Maps over two axes", blocks: vec![Block::figures("maps")] });
    }
    if !drawn.figures["axes"].is_empty() {
        let shown = if drawing.cases < findings.cases {
            format!("{} of {} cases are drawn, evenly chosen; cases.parquet has all", drawing.cases, findings.cases)
        } else {
            "Every case is drawn".to_owned()
        };
        let about =
            format!("{shown}. The line connects the medians of the drawn cases at each level or class of the axis.");
        let blocks = vec![Block::text(about), Block::figures("axes")];
        sections.push(Section { id: "axes", title: "Metrics over each axis", blocks });
    }
    let file = Block::File { name: "sweep.toml".into(), text: page.canonical.to_owned() };
    sections.push(Section { id: "scenario", title: "Inputs", blocks: vec![file] });
    let note = "Run this command in the folder of the sweep's file. --case N prints case N as a scenario.".into();
    let commands = vec![Block::Command { line: page.line.to_owned(), note }];
    sections.push(Section { id: "again", title: "Reproduce", blocks: commands });
    let name = design.name.clone();
    let lead = heading(design, findings).lines().map(str::to_owned).chain(warned(&findings.warnings)).collect();
    Page { command: "trocar sweep", heading: name, lead, sections, drawn }.render()
}

fn metrics(design: &Design, findings: &Findings) -> Section {
    let row = |(summary, column): (&trocar_studies::sweep::Summary, &Column)| Row {
        cells: summary_row(summary).to_vec(),
        meaning: column.meaning,
    };
    let rows = findings.summaries.iter().zip(&design.columns).map(row).collect();
    let head = SUMMARY_HEADING.map(str::to_owned).to_vec();
    let table =
        Block::Table { caption: "Metrics over all cases, and their meaning".into(), head, rows, is_text: false };
    let note = "Intervals in brackets and after ± are 95 % confidence intervals of the median and the mean. “Cases with value” counts the \
                cases in which the metric is defined.";
    Section { id: "metrics", title: "Metrics", blocks: vec![table, Block::text(note)] }
}

impl DrawnCases {
    /// Reads the drawn cases. All cases are divided into equal parts, and one case is drawn from each part. Its position varies from
    /// part to part, so that a regular step does not skip a level of an axis.
    ///
    /// # Errors
    /// Returns the errors of the rows.
    pub fn of(design: &Design, rows: &Rows) -> Result<Self, SweepError> {
        let all = design.cases();
        let parts = all.min(MAX_CASES);
        let of_part = |part: u64| {
            let bound = |part: u64| (u128::from(part) * u128::from(all) / u128::from(parts.max(1))) as u64;
            let (start, end) = (bound(part), bound(part + 1));
            // Multiples of the golden ratio are spread evenly over the part.
            start + (part.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 11) % (end - start).max(1)
        };
        let mut drawing =
            Self { axes: vec![vec![]; design.axes.len()], metrics: vec![vec![]; design.focus.len()], cases: parts };
        let (sampler, mut coordinates, mut values) = (design.coordinates(), vec![], vec![]);
        let mut part = 0;
        rows.each(|case, _, metrics| {
            if part >= parts || case != of_part(part) {
                return Ok(());
            }
            part += 1;
            sampler.values(case, &mut coordinates, &mut values);
            for (column, (value, axis)) in drawing.axes.iter_mut().zip(values.iter().zip(&design.axes)) {
                column.push(place(axis, value));
            }
            for (column, index) in drawing.metrics.iter_mut().zip(&design.focus) {
                column.push(metrics[*index]);
            }
            Ok(())
        })?;
        Ok(drawing)
    }
}

/// Returns the position of a value on its axis: a number itself, or the index of a word in the list, from 1.
fn place(axis: &Axis, value: &Value) -> f64 {
    match (value, &axis.levels) {
        (Value::Number(number), _) => *number,
        (Value::Whole(whole), _) => *whole as f64,
        (_, Levels::List(list)) => list.iter().position(|level| level == value).map_or(f64::NAN, |at| (at + 1) as f64),
        _ => f64::NAN,
    }
}

fn charts(design: &Design, drawing: &DrawnCases) -> Vec<Json> {
    let mut charts = vec![];
    for (metrics, index) in drawing.metrics.iter().zip(&design.focus) {
        let column = &design.columns[*index];
        for (values, axis) in drawing.axes.iter().zip(&design.axes) {
            if axis.count() != Some(1) && charts.len() < MAX_CHARTS {
                charts.push(chart(column, axis, values, metrics));
            }
        }
    }
    charts
}

fn chart(column: &Column, axis: &Axis, values: &[f64], metrics: &[f64]) -> Json {
    let (factor, unit) = readable(column.unit);
    let words = match &axis.levels {
        Levels::List(list) if !axis.is_numeric() => {
            let word =
                |(at, level): (usize, &Value)| format!("{}: {}", at + 1, level.to_toml().to_string().trim_matches('"'));
            format!(", {}", list.iter().enumerate().map(word).collect::<Vec<_>>().join(", "))
        }
        _ => String::new(),
    };
    let mut cases: Vec<(f64, f64)> =
        values.iter().zip(metrics).filter(|(x, _)| x.is_finite()).map(|(x, y)| (*x, factor * y)).collect();
    cases.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
    let unit = if unit.is_empty() { String::new() } else { format!(" ({})", unit.trim_start()) };
    let medians = medians(&cases, axis.is_log());
    figures::cases(&CasesView {
        x_caption: format!("{}{words}", axis.key.path),
        is_log: axis.is_log(),
        y_caption: format!("{} over {}{unit}", column.name, axis.key.path),
        cases: &cases,
        medians: &medians,
    })
    .for_page(2 * cases.len())
}

/// Returns the median of each class at its middle case. `cases` are sorted by x. If there are few distinct values of x, each of
/// them is a class.
fn medians(cases: &[(f64, f64)], log: bool) -> Vec<(f64, f64)> {
    let mut medians = vec![];
    let Some((&(low, _), &(high, _))) = cases.first().zip(cases.last()) else { return medians };
    let distinct = cases.chunk_by(|a, b| a.0 == b.0).count();
    let scale = |x: f64| if log { x.ln() } else { x };
    let width = (scale(high) - scale(low)) / CLASSES as f64;
    let class = |x: f64| if width > 0.0 { (((scale(x) - scale(low)) / width) as usize).min(CLASSES - 1) } else { 0 };
    let is_same = |a: &(f64, f64), b: &(f64, f64)| {
        if distinct <= 2 * CLASSES { a.0 == b.0 } else { class(a.0) == class(b.0) }
    };
    for group in cases.chunk_by(is_same) {
        let mut values: Vec<f64> = group.iter().map(|(_, y)| *y).filter(|y| y.is_finite()).collect();
        if let Some(median) = trocar_base::quantiles::quantile_of(&mut values, 0.5) {
            medians.push((group[group.len() / 2].0, median));
        }
    }
    medians
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_level_has_its_median() {
        let cases = [(1.0, 5.0), (1.0, 1.0), (1.0, 3.0), (2.0, f64::NAN), (4.0, 7.0), (4.0, 9.0)];
        assert_eq!(medians(&cases, true), [(1.0, 3.0), (4.0, 8.0)]);
    }

    #[test]
    fn an_axis_without_levels_has_classes() {
        let cases: Vec<(f64, f64)> = (0..1000).map(|k| (f64::from(k), f64::from(k))).collect();
        let medians = medians(&cases, false);
        assert_eq!(medians.len(), CLASSES);
        assert!(medians.is_sorted_by_key(|median| median.1));
    }
}
