use super::decision::decision_panel;
use super::limits::{Signal, shared};
use super::parameters::{estimate_axis, extra_caption};
use super::{EstimationView, FigureError, RunView, check_runs, events};
use trocar_document::figure::{
    Axis, Entry, Events, Figure, HAND, HAND_OF_CLASSICAL, Panel, Row, Sample, Series, Stroke, X_TICKS, of_runs,
};

const MAX_DETAILED: usize = 2;

/// Draws the slave position (above) and the feedback force (below) of all runs in the same axes.
///
/// `window` is the displayed time in s; default: 0.4 s before to 1.6 s after the first rupture, or the whole record.
pub fn overlay<'a>(runs: &[RunView<'a>], window: Option<(f64, f64)>) -> Result<Figure<'a>, FigureError> {
    check_runs("overlay", runs)?;
    let sheet = Sheet::of(runs, events::window(runs, window));
    let rows = vec![
        Row::of(130.0, sheet.positions("Slave position (mm)", runs.iter().map(|run| run.slave_position_m))),
        Row::of(130.0, sheet.feedback(runs)),
    ];
    Ok(Figure { name: String::new(), legend: sheet.legend(runs), rows })
}

/// Draws all signals of runs in the same axes for a page: positions, forces, estimates, decision function. Runs without
/// samples in the window (s) have no lines. With more than two runs, masters, alarms and modes are omitted.
pub fn signals<'a>(runs: &[(RunView<'a>, EstimationView<'a>)], window: (f64, f64)) -> Result<Figure<'a>, FigureError> {
    let views: Vec<RunView<'a>> = runs.iter().map(|(run, _)| run.clone()).collect();
    let estimations: Vec<&EstimationView<'a>> = runs.iter().map(|(_, estimation)| estimation).collect();
    if views.iter().all(|run| run.time_s.is_empty()) {
        return Err(FigureError::Empty { figure: "signals" });
    }
    let mut sheet = Sheet::of(&views, window);
    let is_detailed = runs.len() <= MAX_DETAILED;
    if !is_detailed {
        sheet.events = Events { ruptures: sheet.events.ruptures, ..Events::default() };
    }
    let mut positions = sheet.positions("Position (mm)", views.iter().map(|run| run.slave_position_m));
    if is_detailed {
        let masters = [HAND, HAND_OF_CLASSICAL];
        let slave = |(run, line): (&RunView<'_>, &Stroke)| (Sample::Line(*line), format!("slave, {}", run.name));
        positions.legend = views.iter().zip(&sheet.strokes).map(slave).collect();
        for (run, line) in views.iter().rev().zip(masters) {
            // Draw the masters below the slaves.
            positions.series.insert(0, Series::new(run.time_s, run.master_position_m, line).times(1e3));
            positions.legend.push((Sample::Line(line), format!("master, {}", run.name)));
        }
        let of_run =
            |run: &RunView<'a>| [run.slave_position_m, run.master_position_m].map(|y| Signal::position(run.time_s, y));
        let all = views.iter().flat_map(of_run);
        positions.y = shared(&all.collect::<Vec<_>>(), window);
    }
    let estimate = |caption: &str, column: fn(&EstimationView<'a>) -> &'a [f64]| {
        let columns: Vec<&[f64]> = estimations.iter().map(|view| column(view)).collect();
        sheet.panel(estimate_axis(columns.iter().copied().flatten()), caption, 1.0, columns)
    };
    let felt = views.iter().map(|run| run.operator_force_n);
    let mut panels = vec![
        Panel { id: "position", ..positions },
        Panel { id: "felt-force", ..sheet.forces("Force on the hand (N)", felt) },
        Panel { id: "feedback-force", ..sheet.feedback(&views) },
        sheet.forces("Tissue force (N)", views.iter().map(|run| run.tissue_force_n)),
        estimate("Stiffness (N/m)", |view| view.stiffness_n_per_m),
        estimate("Damping (N·s/m)", |view| view.damping_n_s_per_m),
    ];
    if let Some((name, _)) = estimations.iter().find_map(|view| view.extra_parameter) {
        panels.push(estimate(extra_caption(name), |view| view.extra_parameter.map_or(&[][..], |(_, column)| column)));
    }
    panels.push(sheet.forces("Prediction error e (N)", estimations.iter().map(|view| view.residual_n)));
    let decision = decision_panel(&estimations, Axis::exact(window, X_TICKS), sheet.events.clone());
    let columns = estimations.iter().map(|view| view.decision).collect();
    panels.push(Panel { series: sheet.series(1.0, columns), ..decision });
    let rows = panels.into_iter().map(|panel| Row::of(130.0, panel)).collect();
    Ok(Figure { name: String::new(), legend: sheet.legend(&views), rows })
}

struct Sheet<'a> {
    window: (f64, f64),
    times_s: Vec<&'a [f64]>,
    strokes: Vec<Stroke>,
    events: Events,
}

impl<'a> Sheet<'a> {
    fn of(runs: &[RunView<'a>], window: (f64, f64)) -> Self {
        Self {
            window,
            times_s: runs.iter().map(|run| run.time_s).collect(),
            strokes: of_runs(runs.iter().map(|run| run.is_augmented)),
            events: merged(runs),
        }
    }

    fn legend(&self, runs: &[RunView<'_>]) -> Vec<Entry> {
        let names = runs.iter().zip(&self.strokes).map(|(run, line)| (Sample::Line(*line), run.name.to_owned()));
        names.chain(events::entries(&[&self.events], self.window)).collect()
    }

    /// Dashed lines are drawn last, so coinciding lines are both visible.
    fn series(&self, scale: f64, columns: Vec<&'a [f64]>) -> Vec<Series<'a>> {
        let lines = columns.into_iter().zip(&self.times_s).zip(&self.strokes);
        let mut series: Vec<_> = lines.map(|((y, x), line)| Series::new(*x, y, *line).times(scale)).collect();
        series.sort_by_key(|trace| !trace.stroke.dashes.is_empty());
        series
    }

    fn panel(&self, y: Axis, caption: &str, scale: f64, columns: Vec<&'a [f64]>) -> Panel<'a> {
        Panel {
            events: self.events.clone(),
            series: self.series(scale, columns),
            ..Panel::over_time(Axis::exact(self.window, X_TICKS), y, caption)
        }
    }

    fn positions(&self, caption: &str, columns: impl Iterator<Item = &'a [f64]>) -> Panel<'a> {
        let columns: Vec<_> = columns.collect();
        let signals = self.times_s.iter().zip(&columns).map(|(time_s, y)| Signal::position(time_s, y));
        self.panel(shared(&signals.collect::<Vec<_>>(), self.window), caption, 1e3, columns)
    }

    fn forces(&self, caption: &str, columns: impl Iterator<Item = &'a [f64]>) -> Panel<'a> {
        let columns: Vec<_> = columns.collect();
        let signals = self.times_s.iter().zip(&columns).map(|(time_s, y)| Signal::force(time_s, y));
        self.panel(shared(&signals.collect::<Vec<_>>(), self.window), caption, 1.0, columns)
    }

    fn feedback(&self, runs: &[RunView<'a>]) -> Panel<'a> {
        self.forces("Feedback force (N)", runs.iter().map(|run| run.feedback_force_n))
    }
}

/// The events of all runs, with the shades of the first augmented run: overlapping shades would look like a third mode.
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
