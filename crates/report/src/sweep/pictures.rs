//! A sweep's figures, each with its numbers as CSV.

use super::text::{heat_map_csv, tornado_csv};
use crate::figures::{self, AxisView, Figure, FigureError, HeatView, TornadoView};
use crate::pictures::keep;
use crate::{Folder, PictureError};
use trocar_document::readable;
use trocar_scenario::unit_of;
use trocar_studies::sweep::{Design, Findings, HeatMap};

/// Writes `tornado.svg`, `.png` and `.csv`, and the same three files of a heat map `heat_METRIC` for each metric in focus.
///
/// # Errors
/// [`PictureError`].
pub fn sweep_pictures(folder: &Folder, design: &Design, findings: &Findings) -> Result<(), PictureError> {
    for map in &findings.heat_maps {
        let name = format!("heat_{}", design.columns[map.column].name);
        folder.write(&format!("{name}.csv"), heat_map_csv(design, map).as_bytes())?;
        keep(folder, &name, &heat_figure(design, map)?)?;
    }
    if design.axes.is_empty() {
        return Ok(());
    }
    let views: Vec<TornadoView<'_>> = findings
        .influences
        .iter()
        .map(|influences| TornadoView {
            metric: &design.columns[influences.column].name,
            bars: influences.of_axes.iter().map(|i| (i.axis.as_str(), i.epsilon_squared, i.rank_regression)).collect(),
        })
        .collect();
    let figure = figures::tornado(&design.name, &views)?;
    folder.write("tornado.csv", tornado_csv(design, findings).as_bytes())?;
    keep(folder, "tornado", &figure)
}

/// Returns the figure of a metric's mean over two axes.
pub(crate) fn heat_figure(design: &Design, map: &HeatMap) -> Result<Figure<'static>, FigureError> {
    let column = &design.columns[map.column];
    let (factor, unit) = readable(column.unit);
    let over = match design.seeds {
        1 => String::new(),
        seeds => format!(" (mean over {seeds} seeds)"),
    };
    let label = &column.label;
    let caption = if unit.is_empty() { format!("{label}{over}") } else { format!("{label} in{unit}{over}") };
    let named = [map.x_axis, map.y_axis].map(|axis| {
        let path = design.axes[axis].key.path.as_ref();
        unit_of(path).map_or_else(|| path.to_owned(), |unit| format!("{path} ({unit})"))
    });
    let axis = |name, axis: usize| AxisView { name, log: design.axes[axis].is_log() };
    let means: Vec<f64> = map.cells.iter().map(|cell| factor * cell.mean.unwrap_or(f64::NAN)).collect();
    let x: Vec<f64> = map.cells.iter().take(map.x_count).map(|cell| cell.x).collect();
    let y: Vec<f64> = map.cells.iter().step_by(map.x_count.max(1)).map(|cell| cell.y).collect();
    let axes = [axis(&named[0], map.x_axis), axis(&named[1], map.y_axis)];
    figures::heat_map(&HeatView { name: &design.name, caption: &caption, axes, x, y, means: &means })
}
