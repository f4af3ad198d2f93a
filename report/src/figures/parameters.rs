//! The estimated tissue parameters over time, as in figures 5 and 7 of the paper.

use super::axis::{Axis, X_TICKS, Y_TICKS, quantile_extent};
use super::grid::{Grid, Row};
use super::panel::{Panel, Trace};
use super::style::ALONE;
use super::{EstimationView, Figure, FigureError, events};

/// Quantile that sets the axes; the first estimates after contact can be very large.
const SHOWN: f64 = 0.995;

/// Draws the estimated stiffness, the estimated damping and, if any, the extra parameter, one below the other. The axes span the
/// quantiles from 0.5 % to 99.5 %; values beyond are cut off.
///
/// # Errors
/// [`FigureError::Empty`] without samples, [`FigureError::Length`] for columns of unequal lengths.
pub fn parameters(view: &EstimationView<'_>) -> Result<Figure, FigureError> {
    view.check("parameters")?;
    let (time, window) = view.time_axis(X_TICKS);
    let events = events::of_estimation(view);
    let row = |(y, y_caption)| {
        let y: &[f64] = y;
        let range = quantile_extent(y.iter().copied(), SHOWN).unwrap_or((0.0, 1.0));
        let panel = Panel {
            events: events.clone(),
            traces: vec![Trace { x: view.time_s, y, scale: 1.0, stroke: ALONE }],
            ..Panel::over_time(time.clone(), Axis::padded(range, Y_TICKS), y_caption)
        };
        Row { title: None, height: 360.0, panels: vec![panel] }
    };
    let mut rows =
        vec![row((view.stiffness_n_per_m, "Stiffness (N/m)")), row((view.damping_n_s_per_m, "Damping (N·s/m)"))];
    rows.extend(
        view.extra_parameter
            .map(|(name, column)| row((column, if name == "power" { "Power" } else { "Friction (N)" }))),
    );
    Grid { legends: Vec::new(), common: events::entries(&[&events], window), rows }.draw()
}
