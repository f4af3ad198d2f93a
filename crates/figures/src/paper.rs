//! Figures for the reproduction of the paper: a force and a distance over time, and the parts of the estimated force.

use std::borrow::Cow;

use super::{EstimationView, FigureError, RunView, check, events, parameters};
use trocar_document::figure::{
    Axis, COMPUTED, Events, Figure, LIMIT, Panel, Row, Sample, Series, Stroke, TISSUE, X_TICKS, Y_TICKS, extent,
};

pub fn force<'a>(run: &RunView<'a>) -> Result<Figure<'a>, FigureError> {
    let range = extent(run.tissue_force_n.iter().copied()).unwrap_or((0.0, 1.0));
    over_time(run, Axis::padded(range, Y_TICKS), "Force (N)", run.tissue_force_n.into(), TISSUE)
}

/// In N².
pub fn distance<'a>(
    run: &RunView<'a>,
    caption: &str,
    distance_n2: impl Into<Cow<'a, [f64]>>,
) -> Result<Figure<'a>, FigureError> {
    let distance_n2 = distance_n2.into();
    let max = extent(distance_n2.iter().copied()).map_or(0.0, |range| range.1);
    over_time(run, Axis::from_zero(max, Y_TICKS), caption, distance_n2, COMPUTED)
}

fn over_time<'a>(
    run: &RunView<'a>,
    axis: Axis,
    caption: &str,
    values: Cow<'a, [f64]>,
    line: Stroke,
) -> Result<Figure<'a>, FigureError> {
    check("paper", run.name, run.time_s.len(), &[("values", values.len())])?;
    let window = extent(run.time_s.iter().copied()).unwrap_or((0.0, 1.0));
    // Mark only true ruptures, because alarms would depend on the detector.
    let events = Events { ruptures: run.rupture_times_s.to_vec(), ..Events::default() };
    let panel = Panel {
        events: events.clone(),
        series: vec![Series::new(run.time_s, values, line)],
        ..Panel::over_time(Axis::exact(window, X_TICKS), axis, caption)
    };
    let legend = events::entries(&[&events], window);
    Ok(Figure { name: run.name.to_owned(), legend, rows: vec![Row::of(140.0, panel)] })
}

/// Draws the estimated parameters, and below them the parts of the estimated force with the paper's sign, `-K p` and
/// `-B v` (in N).
pub fn parameters_with_terms<'a>(
    view: &EstimationView<'a>,
    [elastic_n, viscous_n]: [Vec<f64>; 2],
) -> Result<Figure<'a>, FigureError> {
    let lengths = [("elastic_n", elastic_n.len()), ("viscous_n", viscous_n.len())];
    check("parameters", view.name, view.time_s.len(), &lengths)?;
    let mut figure = parameters(view)?;
    let (time, _) = view.time_axis(X_TICKS);
    let range = extent(elastic_n.iter().chain(&viscous_n).map(|term_n| -term_n)).unwrap_or((0.0, 1.0));
    let names = [(COMPUTED, "\u{2212}K p"), (LIMIT, "\u{2212}B v")];
    let panel = Panel {
        events: events::of_estimation(view),
        series: [(elastic_n, COMPUTED), (viscous_n, LIMIT)]
            .map(|(term_n, line)| Series::new(view.time_s, term_n, line).times(-1.0))
            .into(),
        legend: names.map(|(line, name)| (Sample::Line(line), name.to_owned())).into(),
        ..Panel::over_time(time, Axis::padded(range, Y_TICKS), "Part of the force (N)")
    };
    figure.rows.push(Row::of(115.0, panel));
    Ok(figure)
}
