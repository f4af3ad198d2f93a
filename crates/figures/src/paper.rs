//! The figures that only the reproduction of the paper has: a distance over time, and the principle of the detection.

use std::borrow::Cow;

use super::FigureError;
use super::{RunView, check, events};
use trocar_document::figure::{
    Axis, COMPUTED, Events, Figure, Panel, Point, Row, Series, Stroke, TISSUE, X_TICKS, Y_TICKS, extent,
};

/// Draws the measured force of a run over time, with its ruptures.
///
/// # Errors
/// [`FigureError::Empty`] without samples, [`FigureError::Length`] for columns of unequal lengths.
pub fn force<'a>(run: &RunView<'a>) -> Result<Figure<'a>, FigureError> {
    let range = extent(run.tissue_force_n.iter().copied()).unwrap_or((0.0, 1.0));
    over_time(run, Axis::padded(range, Y_TICKS), "Force (N)", run.tissue_force_n.into(), TISSUE)
}

/// Draws a distance in N² of a run over time, with its ruptures.
///
/// # Errors
/// [`FigureError::Empty`] without samples, [`FigureError::Length`] for columns of unequal lengths.
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
    // Only the true ruptures: a detector would find its own alarms.
    let events = Events { ruptures: run.rupture_times_s.to_vec(), ..Events::default() };
    let panel = Panel {
        events: events.clone(),
        series: vec![Series::new(run.time_s, values, line)],
        ..Panel::over_time(Axis::exact(window, X_TICKS), axis, caption)
    };
    let legend = events::entries(&[&events], window);
    Ok(Figure { name: run.name.to_owned(), legend, rows: vec![Row::of(140.0, panel)] })
}

/// Draws the principle of the detection: from the force and its estimate to the alarm.
#[must_use]
pub fn principle() -> Figure<'static> {
    let mut panel =
        Panel { is_bare: true, ..Panel::new(Axis::exact((0.0, 100.0), 0), "", Axis::exact((0.0, 60.0), 0), "") };
    // Centres of the boxes. All have the same size.
    let boxes = [
        ((22.0, 52.0), "needle in the tissue"),
        ((22.0, 8.0), "estimate K p + B v"),
        ((78.0, 52.0), "residual e"),
        ((78.0, 30.0), "distance s = e²"),
        ((78.0, 8.0), "CUSUM: alarm if g > γ"),
    ];
    const HALF: Point = (21.0, 6.0);
    for ((x, y), text) in boxes {
        let (left, right, low, high) = (x - HALF.0, x + HALF.0, y - HALF.1, y + HALF.1);
        panel.curves.push((vec![(left, low), (right, low), (right, high), (left, high), (left, low)], COMPUTED));
        panel.notes.push(((x, y), text.to_owned()));
    }
    // The estimate goes around the middle to the residual.
    let arrows: [&[Point]; 5] = [
        &[(22.0, 46.0), (22.0, 14.0)],
        &[(43.0, 54.0), (57.0, 54.0)],
        &[(43.0, 8.0), (50.0, 8.0), (50.0, 50.0), (57.0, 50.0)],
        &[(78.0, 46.0), (78.0, 36.0)],
        &[(78.0, 24.0), (78.0, 14.0)],
    ];
    for arrow in arrows {
        panel.curves.push((arrow.to_vec(), COMPUTED));
        let [.., (from_x, from_y), (x, y)] = *arrow else { continue };
        // The head, in units of the axes.
        let (along_x, along_y) = ((x - from_x).signum() * 2.0, (y - from_y).signum() * 3.0);
        let head = if x == from_x {
            vec![(x, y), (x - 1.2, y - along_y), (x + 1.2, y - along_y)]
        } else {
            vec![(x, y), (x - along_x, y - 1.8), (x - along_x, y + 1.8)]
        };
        panel.fills.push((head, COMPUTED.color));
    }
    for (at, text) in [((30.5, 30.0), "p, v, f"), ((50.0, 57.5), "force f"), ((62.5, 41.0), "estimated f")] {
        panel.notes.push((at, text.to_owned()));
    }
    Figure { name: "Detection by a model of the force".to_owned(), legend: vec![], rows: vec![Row::of(150.0, panel)] }
}
