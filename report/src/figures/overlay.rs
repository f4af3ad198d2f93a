//! Slave position and feedback force of several runs in the same axes.

use super::axis::{Axis, X_TICKS};
use super::grid::{Grid, Row, Sample};
use super::limits::{Signal, shared};
use super::panel::{Events, Panel, Trace};
use super::style::{RUNS, Stroke};
use super::{Figure, FigureError, RunView, check_runs, events};

/// Draws the slave position (above) and the feedback force (below) of all runs in the same axes.
///
/// `window` is the displayed time in s. Its default is from 0.4 s before to 1.6 s after the first rupture, or the whole record
/// without a rupture.
///
/// # Errors
/// [`FigureError::Empty`] without runs or for a run without samples, [`FigureError::Length`] for columns of unequal lengths.
pub fn overlay(runs: &[RunView<'_>], window: Option<(f64, f64)>) -> Result<Figure, FigureError> {
    check_runs("overlay", runs)?;
    let window = events::window(runs, window);
    let positions = runs.iter().map(|run| Signal::position(run, run.slave_position_m));
    let forces = runs.iter().map(|run| Signal::force(run, run.feedback_force_n));
    let position = shared(&positions.collect::<Vec<_>>(), window);
    let force = shared(&forces.collect::<Vec<_>>(), window);
    let events = merged(runs);

    let styled = || runs.iter().zip(RUNS.iter().cycle());
    let panel = |y: Axis, y_caption, traces| Panel {
        events: events.clone(),
        traces: dashes_last(traces),
        ..Panel::over_time(Axis::exact(window, X_TICKS), y, y_caption)
    };
    let slave = styled().map(|(run, line)| trace(run.time_s, run.slave_position_m, 1e3, line)).collect();
    let feedback = styled().map(|(run, line)| trace(run.time_s, run.feedback_force_n, 1.0, line)).collect();
    let row = |panel| Row { title: None, height: 400.0, panels: vec![panel] };
    let names = styled().map(|(run, line)| (Sample::Line(*line), run.name.to_owned()));
    Grid {
        legends: vec![names.collect()],
        common: events::entries(&[&events], window),
        rows: vec![
            row(panel(position, "Slave position (mm)", slave)),
            row(panel(force, "Feedback force (N)", feedback)),
        ],
    }
    .draw()
}

fn trace<'a>(x: &'a [f64], y: &'a [f64], scale: f64, stroke: &Stroke) -> Trace<'a> {
    Trace { x, y, scale, stroke: *stroke }
}

/// Draws dashed lines last, so that both lines are visible where runs coincide.
fn dashes_last(mut traces: Vec<Trace<'_>>) -> Vec<Trace<'_>> {
    traces.sort_by_key(|trace| !trace.stroke.dashes.is_empty());
    traces
}

/// Returns the events of all runs. The shades are those of the first augmented run, because overlapping shades would look like a
/// third mode.
fn merged(runs: &[RunView<'_>]) -> Events {
    let mut all = Events::default();
    for events in runs.iter().map(events::of_run) {
        if all.shades.is_empty() {
            all.shades = events.shades;
        }
        all.ruptures.extend(events.ruptures);
        all.alarms.extend(events.alarms);
    }
    all
}
