//! Forces and positions of runs, one row per run, as in figures 15 and 16 of the paper.

use super::axis::{Axis, X_TICKS};
use super::grid::{Entry, Grid, Row, Sample};
use super::limits::{Signal, shared};
use super::panel::{Events, Panel, Trace};
use super::style::{HUMAN, MAIN, Stroke, UNDERLAY};
use super::{Figure, FigureError, RunView, check_runs, events};

/// Maximum number of time ticks of a panel of half the page's width.
const HALF_WIDTH_TICKS: usize = X_TICKS - 1;

/// A signal, its line style, its name in the legend.
type Line<'a> = (&'a [f64], Stroke, &'static str);

/// Draws the forces (left) and the positions (right) of each run. All rows have the same axes.
///
/// `window` is the displayed time in s. Its default is from 0.4 s before to 1.6 s after the first rupture, or the whole record
/// without a rupture.
///
/// # Errors
/// [`FigureError::Empty`] without runs or for a run without samples, [`FigureError::Length`] for columns of unequal lengths.
pub fn comparison(runs: &[RunView<'_>], window: Option<(f64, f64)>) -> Result<Figure, FigureError> {
    check_runs("comparison", runs)?;
    let window = events::window(runs, window);
    let time = Axis::exact(window, HALF_WIDTH_TICKS);
    let (mut forces, mut positions) = (Vec::new(), Vec::new());
    for run in runs {
        forces.extend(force_lines(run).map(|(values, ..)| Signal::force(run, values)));
        positions.extend(position_lines(run).map(|(values, ..)| Signal::position(run, values)));
    }
    let force = shared(&forces, window);
    let position = shared(&positions, window);
    let events: Vec<Events> = runs.iter().map(events::of_run).collect();
    let rows = runs.iter().zip(&events).map(|(run, events)| {
        let panel = |y: &Axis, y_caption, traces| Panel {
            events: events.clone(),
            traces,
            ..Panel::over_time(time.clone(), y.clone(), y_caption)
        };
        Row {
            title: Some(run.name),
            height: 400.0,
            panels: vec![
                panel(&force, "Force (N)", traces(run, &force_lines(run), 1.0)),
                panel(&position, "Position (mm)", traces(run, &position_lines(run), 1e3)),
            ],
        }
    });
    Grid {
        rows: rows.collect(),
        legends: vec![legend(&force_lines(&runs[0])), legend(&position_lines(&runs[0]))],
        common: events::entries(&events.iter().collect::<Vec<_>>(), window),
    }
    .draw()
}

fn force_lines<'a>(run: &RunView<'a>) -> [Line<'a>; 3] {
    [
        (run.tissue_force_n, UNDERLAY, "tissue force"),
        (run.feedback_force_n, MAIN, "feedback force"),
        (run.operator_force_n, HUMAN, "felt force"),
    ]
}

fn position_lines<'a>(run: &RunView<'a>) -> [Line<'a>; 2] {
    [(run.slave_position_m, MAIN, "slave"), (run.master_position_m, HUMAN, "master")]
}

fn traces<'a>(run: &RunView<'a>, lines: &[Line<'a>], scale: f64) -> Vec<Trace<'a>> {
    let trace = |&(y, stroke, _): &Line<'a>| Trace { x: run.time_s, y, scale, stroke };
    lines.iter().map(trace).collect()
}

fn legend(lines: &[Line<'_>]) -> Vec<Entry> {
    lines.iter().map(|&(_, stroke, name)| (Sample::Line(stroke), name.to_owned())).collect()
}
