//! Forces and positions of runs, one row per run, as in figures 15 and 16 of the paper.

use super::limits::{Signal, shared};
use super::{FigureError, RunView, check_runs, events};
use trocar_document::figure::{
    Axis, Events, Figure, HAND, Panel, Row, Sample, Series, Stroke, TISSUE, X_TICKS, of_runs,
};

type Line<'a> = (&'a [f64], Stroke, &'static str);

/// Draws the forces (left) and the positions (right) of each run. All rows have the same axes.
///
/// `window` is the displayed time in s; default: 0.4 s before to 1.6 s after the first rupture, or the whole record.
pub fn comparison<'a>(runs: &[RunView<'a>], window: Option<(f64, f64)>) -> Result<Figure<'a>, FigureError> {
    check_runs("comparison", runs)?;
    let window = events::window(runs, window);
    let time = Axis::exact(window, X_TICKS);
    let strokes = of_runs(runs.iter().map(|run| run.is_augmented));
    let styled = || runs.iter().zip(&strokes);
    let (mut forces, mut positions) = (Vec::new(), Vec::new());
    for (run, line) in styled() {
        forces.extend(force_lines(run, *line).map(|(values, ..)| Signal::force(run.time_s, values)));
        positions.extend(position_lines(run, *line).map(|(values, ..)| Signal::position(run.time_s, values)));
    }
    let force = shared(&forces, window);
    let position = shared(&positions, window);
    let events: Vec<Events> = runs.iter().map(events::of_run).collect();
    let rows = styled().zip(&events).map(|((run, line), events)| {
        let panel = |y: &Axis, y_caption: &str, lines: &[Line<'a>], scale| Panel {
            events: events.clone(),
            series: lines.iter().map(|(y, line, _)| Series::new(run.time_s, *y, *line).times(scale)).collect(),
            legend: lines.iter().map(|(_, line, name)| (Sample::Line(*line), (*name).to_owned())).collect(),
            ..Panel::over_time(time.clone(), y.clone(), y_caption)
        };
        Row {
            title: Some(run.name.to_owned()),
            height: 130.0,
            panels: vec![
                panel(&force, "Force (N)", &force_lines(run, *line), 1.0),
                panel(&position, "Position (mm)", &position_lines(run, *line), 1e3),
            ],
        }
    });
    Ok(Figure {
        name: String::new(),
        legend: events::entries(&events.iter().collect::<Vec<_>>(), window),
        rows: rows.collect(),
    })
}

fn force_lines<'a>(run: &RunView<'a>, line: Stroke) -> [Line<'a>; 3] {
    [
        (run.tissue_force_n, TISSUE, "tissue"),
        (run.feedback_force_n, line, "feedback"),
        (run.operator_force_n, HAND, "felt"),
    ]
}

fn position_lines<'a>(run: &RunView<'a>, line: Stroke) -> [Line<'a>; 2] {
    [(run.slave_position_m, line, "slave"), (run.master_position_m, HAND, "master")]
}
