//! Measured and estimated force, and the prediction error, as in figures 4 and 6 of the paper.

use super::{EstimationView, FigureError, events};
use trocar_document::figure::{Axis, COMPUTED, Figure, Panel, Row, Sample, Series, TISSUE, X_TICKS, Y_TICKS, extent};

pub fn estimation<'a>(view: &EstimationView<'a>) -> Result<Figure<'a>, FigureError> {
    view.check("estimation")?;
    let (time, window) = view.time_axis(X_TICKS);
    let pairs = view.measured_force_n.iter().zip(view.residual_n);
    let estimated: Vec<f64> = pairs.map(|(measured, residual)| measured - residual).collect();
    let error: Vec<f64> = view.residual_n.iter().map(|e| e.abs()).collect();
    let largest = extent(error.iter().copied()).map_or(1.0, |range| range.1);
    let events = events::of_estimation(view);
    let panel = |y, y_caption: &str, series, legend| Panel {
        events: events.clone(),
        series,
        legend,
        ..Panel::over_time(time.clone(), y, y_caption)
    };
    let measured = Series::new(view.time_s, view.measured_force_n, TISSUE);
    let forces = vec![measured, Series::new(view.time_s, estimated, COMPUTED)];
    let names =
        [(TISSUE, "measured"), (COMPUTED, "estimated")].map(|(line, name)| (Sample::Line(line), name.to_owned()));
    let errors = vec![Series::new(view.time_s, error, COMPUTED)];
    let error_axis = Axis::from_zero(largest, Y_TICKS - 1);
    Ok(Figure {
        name: view.name.to_owned(),
        legend: events::entries(&[&events], window),
        rows: vec![
            Row::of(140.0, panel(view.force_axis(), "Force (N)", forces, names.into())),
            Row::of(95.0, panel(error_axis, "Absolute error |e| (N)", errors, vec![])),
        ],
    })
}
