//! A small chart for a terminal: the slave's position around the first rupture.

use super::{FigureError, RunView};
use trocar_document::figure::{Axis, Figure, Panel, Row, Series, extent, of_runs};

const AROUND_S: (f64, f64) = (0.5, 1.5);

const MAX_RUNS: usize = 4;

const MAX_M: f64 = 10.0;

/// Minimum range of positions, in mm, for a needle at rest.
const MIN_RANGE_MM: f64 = 1.0;

/// Draws the slave's position, one row per run on the same axes: around the first rupture, or over the whole time
/// without one.
pub fn sketch<'a>(runs: &[RunView<'a>]) -> Result<Figure<'a>, FigureError> {
    let runs: Vec<&RunView<'a>> = runs.iter().filter(|run| run.time_s.len() > 1).take(MAX_RUNS).collect();
    let ends_s = runs.iter().filter_map(|run| run.time_s.last().copied());
    let last_s = ends_s.reduce(f64::max).ok_or(FigureError::Empty { figure: "sketch" })?;
    let first_s = runs.iter().filter_map(|run| run.rupture_times_s.first().copied()).reduce(f64::min);
    let (from_s, to_s) =
        first_s.map_or((0.0, last_s), |at| ((at - AROUND_S.0).max(0.0), (at + AROUND_S.1).min(last_s)));
    let shown_mm = |run: &&RunView<'a>| {
        let samples = run.time_s.iter().zip(run.slave_position_m);
        let shown = samples.filter(|(time_s, at_m)| (from_s..=to_s).contains(*time_s) && at_m.abs() < MAX_M);
        shown.map(|(_, at_m)| 1e3 * at_m).collect::<Vec<f64>>()
    };
    let (low, high) = extent(runs.iter().flat_map(shown_mm)).unwrap_or((0.0, 0.0));
    let missing_mm = (MIN_RANGE_MM - (high - low)).max(0.0);
    let range_mm = (low - 0.5 * missing_mm, high + 0.5 * missing_mm);
    let strokes = of_runs(runs.iter().map(|run| run.is_augmented));
    let when = if first_s.is_some() { " around rupture 1" } else { "" };
    let row = |(run, stroke): (&&RunView<'a>, _)| {
        let panel = Panel::over_time(Axis::exact((from_s, to_s), 0), Axis::exact(range_mm, 0), "Slave position (mm)");
        let line = Series::new(run.time_s, run.slave_position_m, stroke).times(1e3);
        Row {
            title: Some(format!("{}: slave position{when}, in mm over s", run.name)),
            ..Row::of(60.0, Panel { series: vec![line], ..panel })
        }
    };
    Ok(Figure { name: String::new(), legend: vec![], rows: runs.iter().zip(strokes).map(row).collect() })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_needle_at_rest_has_a_range_and_a_run_without_samples_has_no_chart() {
        let (time_s, at_m) = ([0.0, 1.0, 2.0], [0.01; 3]);
        let run = RunView {
            name: "rest",
            is_augmented: false,
            time_s: &time_s,
            master_position_m: &at_m,
            slave_position_m: &at_m,
            operator_force_n: &at_m,
            tissue_force_n: &at_m,
            feedback_force_n: &at_m,
            mode: &[0; 3],
            event: trocar_document::figure::Shade::Frozen,
            rupture_times_s: vec![].into(),
            alarm_times_s: vec![].into(),
        };
        let figure = sketch(std::slice::from_ref(&run)).expect("described");
        let panel = &figure.rows[0].panels[0];
        assert_eq!((panel.x.low, panel.x.high), (0.0, 2.0));
        assert_eq!((panel.y.low, panel.y.high), (9.5, 10.5));
        assert!(sketch(&[]).is_err());
    }
}
