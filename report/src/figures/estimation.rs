//! Measured and estimated force, and the prediction error, as in figures 4 and 6 of the paper.

use super::axis::{Axis, X_TICKS, Y_TICKS, extent};
use super::grid::{Grid, Row, Sample};
use super::panel::{Panel, Trace};
use super::style::{ALONE, MAIN, UNDERLAY};
use super::{EstimationView, Figure, FigureError, events};

/// Draws the measured and estimated force (above) and the absolute prediction error (below).
///
/// # Errors
/// [`FigureError::Empty`] without samples, [`FigureError::Length`] for columns of unequal lengths.
pub fn estimation(view: &EstimationView<'_>) -> Result<Figure, FigureError> {
    view.check("estimation")?;
    let (time, window) = view.time_axis(X_TICKS);
    let pairs = view.measured_force_n.iter().zip(view.residual_n);
    let estimated: Vec<f64> = pairs.map(|(measured, residual)| measured - residual).collect();
    let error: Vec<f64> = view.residual_n.iter().map(|e| e.abs()).collect();
    let force = view.force_axis();
    let largest = extent(error.iter().copied()).map_or(1.0, |range| range.1);
    let events = events::of_estimation(view);
    let trace = |y, stroke| Trace { x: view.time_s, y, scale: 1.0, stroke };
    let panel =
        |y, y_caption, traces| Panel { events: events.clone(), traces, ..Panel::over_time(time.clone(), y, y_caption) };
    let forces = vec![trace(view.measured_force_n, UNDERLAY), trace(&estimated, MAIN)];
    let errors = vec![trace(&error, ALONE)];
    Grid {
        legends: vec![vec![
            (Sample::Line(UNDERLAY), String::from("measured")),
            (Sample::Line(MAIN), String::from("estimated")),
        ]],
        common: events::entries(&[&events], window),
        rows: vec![
            Row { title: None, height: 440.0, panels: vec![panel(force, "Force (N)", forces)] },
            Row {
                title: None,
                height: 300.0,
                panels: vec![panel(Axis::from_zero(largest, Y_TICKS - 1), "|e| (N)", errors)],
            },
        ],
    }
    .draw()
}
