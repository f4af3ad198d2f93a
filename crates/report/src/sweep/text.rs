//! A sweep's findings as text, CSV and JSON.

use std::fmt::Write as _;

use serde_json::json;

use crate::wrap::wrapped;
use crate::{Table, json};
use trocar_document::shortest;
use trocar_document::{counted, readable, show, significant};
use trocar_metrics::Unit;
use trocar_studies::sweep::{Design, Findings, HeatMap, Influence, Spread, Summary};

/// The heading of the table of metrics.
pub(crate) const SUMMARY_HEADING: [&str; 6] =
    ["metric", "cases with value", "median [95 %]", "5 % to 95 %", "min to max", "mean ± 95 %"];

/// Returns the tables: the distribution of each metric, and the influence of each axis on the metrics in focus.
#[must_use]
pub fn sweep_text(design: &Design, findings: &Findings) -> String {
    let mut text = wrapped(&heading(design, findings), 0);
    let mut table = Table::new(SUMMARY_HEADING);
    for summary in &findings.summaries {
        table.row(summary_row(summary));
    }
    let _ = write!(text, "\n{table}");
    if !design.axes.is_empty() {
        let _ = write!(text, "\n{}", influence_table(design, findings));
        if !design.correlations.is_empty() {
            text.push_str(
                "Axes that vary together share their influence: the index of each includes that of the others.\n",
            );
        }
    }
    text
}

/// Returns the influence of each axis, one per line below the metric.
fn influence_table(design: &Design, findings: &Findings) -> Table {
    let mut table = Table::new(["influence of each axis", "first-order Sobol index", "rank regression", "R²"]);
    for influences in &findings.influences {
        let metric = design.columns[influences.column].label.clone();
        table.row([metric, String::new(), String::new(), share(influences.rank_r_squared)]);
        for influence in &influences.of_axes {
            table.row([
                format!("  {}", influence.axis),
                share(influence.epsilon_squared),
                coefficient(influence.rank_regression),
            ]);
        }
    }
    table
}

pub(crate) fn heading(design: &Design, findings: &Findings) -> String {
    let axes: Vec<&str> = design.axes.iter().map(|axis| &*axis.key.path).collect();
    let points = design.points().unwrap_or(0);
    let mut text = format!(
        "{}: {}, {} ({}) with {} each, over {}\n",
        design.name,
        counted(findings.cases, "case"),
        counted(points, "point"),
        design.scheme.word(),
        counted(design.seeds, "seed"),
        if axes.is_empty() { "no axis".to_owned() } else { axes.join(", ") },
    );
    if findings.diverged > 0 || findings.failed > 0 {
        let (diverged, failed) = (findings.diverged, findings.failed);
        let _ = writeln!(text, "{} diverged, {failed} could not be integrated", counted(diverged, "case"));
    }
    let unchanged = findings.summaries.iter().filter(|summary| summary.is_unchanged(findings.cases));
    let unchanged: Vec<&str> = unchanged.map(|summary| summary.label.as_str()).collect();
    if !unchanged.is_empty() {
        let _ = writeln!(text, "the same in every case: {}", unchanged.join(", "));
    }
    text
}

pub(crate) fn summary_row(summary: &Summary) -> [String; 6] {
    let name = summary.label.clone();
    let defined = summary.defined.to_string();
    let Some(spread) = &summary.spread else {
        return [name, defined, "—".into(), "—".into(), "—".into(), "—".into()];
    };
    let (factor, unit) = readable(summary.unit);
    let number = |value: f64| {
        if summary.unit == Unit::Count && value.fract() == 0.0 {
            format!("{value}")
        } else {
            significant(factor * value)
        }
    };
    let Spread {
        min, quantile_5, median, quantile_95, max, median_low, median_high, mean, mean_ci95_half_width, ..
    } = spread;
    // One value has no interval.
    if summary.defined == 1 {
        let value = format!("{}{unit}", number(*median));
        return [name, defined, value, "—".into(), "—".into(), "—".into()];
    }
    [
        name,
        defined,
        format!("{} [{}, {}]{unit}", number(*median), number(*median_low), number(*median_high)),
        format!("{} to {}{unit}", number(*quantile_5), number(*quantile_95)),
        format!("{} to {}{unit}", number(*min), number(*max)),
        format!("{} ± {}{unit}", significant(factor * mean), significant(factor * mean_ci95_half_width)),
    ]
}

fn share(value: Option<f64>) -> String {
    show(value, Unit::Share)
}

fn coefficient(value: Option<f64>) -> String {
    value.map_or("—".into(), |value| format!("{value:+.3}"))
}

/// Returns `summary.csv`: a row per metric, in SI units. An undefined value is an empty cell.
#[must_use]
pub fn sweep_summary_csv(findings: &Findings) -> String {
    let mut text = "metric,unit,defined,least,quantile_2_5,quantile_5,quantile_25,median,quantile_75,quantile_95,\
                    quantile_97_5,greatest,median_low,median_high,mean,mean_ci95_half_width,standard_deviation\n"
        .to_owned();
    for Summary { metric, unit, defined, spread, .. } in &findings.summaries {
        let numbers = spread.map(|s| {
            [
                s.min,
                s.quantile_2_5,
                s.quantile_5,
                s.quantile_25,
                s.median,
                s.quantile_75,
                s.quantile_95,
                s.quantile_97_5,
                s.max,
                s.median_low,
                s.median_high,
                s.mean,
                s.mean_ci95_half_width,
                s.standard_deviation,
            ]
        });
        let cells = numbers.map_or_else(|| ",".repeat(13), |numbers| numbers.map(shortest).join(","));
        let _ = writeln!(text, "{metric},{},{defined},{cells}", unit.si());
    }
    text
}

/// Returns `tornado.csv`: the influence of each axis on each metric in focus. An undefined value is an empty cell.
#[must_use]
pub fn tornado_csv(design: &Design, findings: &Findings) -> String {
    let mut text = "metric,axis,first_order_sobol,rank_regression,rank_r_squared,ranked\n".to_owned();
    let cell = |value: Option<f64>| value.map_or(String::new(), shortest);
    for influences in &findings.influences {
        let metric = &design.columns[influences.column].name;
        for Influence { axis, epsilon_squared, rank_regression } in &influences.of_axes {
            let numbers = [*epsilon_squared, *rank_regression, influences.rank_r_squared].map(cell).join(",");
            let _ = writeln!(text, "{metric},{axis},{numbers},{}", influences.ranked);
        }
    }
    text
}

/// Returns the cells of a heat map as CSV. An undefined value is an empty cell.
#[must_use]
pub fn heat_map_csv(design: &Design, map: &HeatMap) -> String {
    let [x, y] = [map.x_axis, map.y_axis].map(|axis| &*design.axes[axis].key.path);
    let name = &design.columns[map.column].name;
    let mut text = format!("{x},{y},defined,{name},mean_ci95_half_width\n");
    let cell = |value: Option<f64>| value.map_or(String::new(), shortest);
    for c in &map.cells {
        let (mean, half_width) = (cell(c.mean), cell(c.mean_ci95_half_width));
        let _ = writeln!(text, "{},{},{},{mean},{half_width}", shortest(c.x), shortest(c.y), c.defined);
    }
    text
}

/// Returns `summary.json`: all findings except the rows.
#[must_use]
pub fn sweep_json(design: &Design, hash: &str, findings: &Findings) -> String {
    let named = |index: usize| design.columns[index].name.as_str();
    let influences: Vec<_> = findings
        .influences
        .iter()
        .map(|influences| {
            json!({
                "metric": named(influences.column),
                "of_axes": influences.of_axes,
                "rank_r_squared": influences.rank_r_squared,
                "ranked": influences.ranked,
            })
        })
        .collect();
    json::render(&json!({
        "trocar_version": env!("CARGO_PKG_VERSION"),
        "sweep": design.name,
        "sweep_sha256": hash,
        "cases": findings.cases,
        "points": design.points(),
        "seeds": design.seeds,
        "diverged": findings.diverged,
        "failed": findings.failed,
        "metrics": findings.summaries,
        "influences": influences,
        "warnings": findings.warnings,
    }))
}
