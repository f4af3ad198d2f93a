//! Slave position and feedback force of several runs in the same axes.

use super::axis::{Axis, X_TICKS};
use super::figure::{Figure, Row};
use super::legend::Sample;
use super::limits::{Signal, shared};
use super::panel::{Events, Panel, Trace};
use super::style::of_runs;
use super::{FigureError, RunView, check_runs, events};

/// Draws the slave position (above) and the feedback force (below) of all runs in the same axes.
///
/// `window` is the displayed time in s. Its default is from 0.4 s before to 1.6 s after the first rupture, or the whole record
/// without a rupture.
///
/// # Errors
/// [`FigureError::Empty`] without runs or for a run without samples, [`FigureError::Length`] for columns of unequal lengths.
pub fn overlay<'a>(runs: &[RunView<'a>], window: Option<(f64, f64)>) -> Result<Figure<'a>, FigureError> {
    check_runs("overlay", runs)?;
    let window = events::window(runs, window);
    let positions = runs.iter().map(|run| Signal::position(run, run.slave_position_m));
    let forces = runs.iter().map(|run| Signal::force(run, run.feedback_force_n));
    let position = shared(&positions.collect::<Vec<_>>(), window);
    let force = shared(&forces.collect::<Vec<_>>(), window);
    let events = merged(runs);

    let strokes = of_runs(runs.iter().map(|run| run.is_augmented));
    let styled = || runs.iter().zip(strokes.iter().copied());
    let panel = |y: Axis, y_caption: &str, traces| Panel {
        events: events.clone(),
        traces: dashes_last(traces),
        ..Panel::over_time(Axis::exact(window, X_TICKS), y, y_caption)
    };
    let slave = styled().map(|(run, line)| Trace::new(run.time_s, run.slave_position_m, line).times(1e3)).collect();
    let feedback = styled().map(|(run, line)| Trace::new(run.time_s, run.feedback_force_n, line)).collect();
    let names = styled().map(|(run, line)| (Sample::Line(line), run.name.to_owned()));
    Ok(Figure {
        name: String::new(),
        legend: names.chain(events::entries(&[&events], window)).collect(),
        rows: vec![
            Row::of(130.0, panel(position, "Slave position (mm)", slave)),
            Row::of(130.0, panel(force, "Feedback force (N)", feedback)),
        ],
    })
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
