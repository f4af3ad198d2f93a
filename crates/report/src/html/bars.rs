//! The influence of the axes on a metric, as bars in a table.

use serde::Serialize;

use trocar_document::show;
use trocar_metrics::Unit;
use trocar_studies::sweep::{Design, Findings};

/// The influence of an axis on a metric. Widths are in per cent of the width of the cell.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Influence {
    metric: String,
    /// Number of rows of the metric in its first row, otherwise 0.
    rows: usize,
    axis: String,
    index: String,
    index_width: String,
    slope: String,
    /// Start of the bar of the slope; 50 is a slope of 0.
    slope_from: String,
    slope_width: String,
    rises: bool,
    /// R² of the rank regression of the metric.
    explained: String,
}

/// Returns a row per metric in focus and axis, the strongest axis first.
pub(super) fn influences(design: &Design, findings: &Findings) -> Vec<Influence> {
    let per_cent = |share: f64| format!("{:.2}", 100.0 * share.clamp(0.0, 1.0));
    let of_metric = |influences: &trocar_studies::sweep::Influences| {
        let metric = design.columns[influences.column].label.clone();
        let explained = show(influences.rank_r_squared, Unit::Share);
        let of_axis = |(index, influence): (usize, &trocar_studies::sweep::Influence)| {
            let slope = influence.rank_regression;
            let size = slope.map_or(0.0, |slope| 0.5 * slope.abs());
            Influence {
                metric: metric.clone(),
                rows: if index == 0 { influences.of_axes.len() } else { 0 },
                axis: influence.axis.to_owned(),
                index: show(influence.epsilon_squared, Unit::Share),
                index_width: per_cent(influence.epsilon_squared.unwrap_or(0.0)),
                slope: slope.map_or("—".into(), |slope| format!("{slope:+.3}")),
                slope_from: per_cent(if slope.is_some_and(|slope| slope < 0.0) { 0.5 - size } else { 0.5 }),
                slope_width: per_cent(size),
                rises: slope.is_some_and(|slope| slope > 0.0),
                explained: explained.clone(),
            }
        };
        influences.of_axes.iter().enumerate().map(of_axis).collect::<Vec<_>>()
    };
    findings.influences.iter().flat_map(of_metric).collect()
}
