//! The charts of runs and of estimations over time.

use super::chart::{COLOURS, Chart, ChartAxis, Columns, Extras, Level, Mark, Series};
use super::digits::Few;
use super::events;
use super::thin::kept;
use trocar_sim::run::Run;

/// Runs that charts show at most; a line more is a line too many.
pub(super) const MAX_RUNS: usize = 8;

/// Stretches that all runs together are cut into, so that a page stays below 2 MB.
const STRETCHES: usize = 1_300;

/// Newtons and millimetres that no needle insertion reaches.
const PLAUSIBLE: f64 = 1e3;

/// One of the quantities of a trace, by the column's name.
type Quantity<'a> = (&'a str, fn(&Run) -> &[f64]);

/// How many stretches each of some runs is cut into.
pub(super) fn stretches(runs: usize) -> usize {
    STRETCHES / runs.max(2)
}

/// The charts of a run, or of several over one another.
pub(super) fn charts(runs: &[&Run]) -> Vec<Chart> {
    let runs = &runs[..runs.len().min(MAX_RUNS)];
    let extras = extras(runs);
    let chart = |title: &str, y: (&str, &'static str)| {
        let chart = Chart::new(title, ChartAxis::new("time", "s"), ChartAxis::new(y.0, y.1));
        Chart { extras: Extras { thresholds: vec![], ..extras.clone() }, ..chart }
    };
    let mut charts = vec![];
    let slave: Quantity<'_> = ("slave", |run| &run.trace.slave_position_m);
    let master: Quantity<'_> = ("master", |run| &run.trace.master_position_m);
    let positions = chart("Positions", ("position", "mm"));
    charts.push(Chart { mark_labels: true, height: 280, ..drawn(positions, runs, &[slave, master], 1e3) });
    let fed_back: Quantity<'_> = ("fed back", |run| &run.trace.feedback_force_n);
    let hand: Quantity<'_> = ("hand", |run| &run.trace.operator_force_n);
    let tissue: Quantity<'_> = ("tissue", |run| &run.trace.tissue_force_n);
    if let [_] = runs {
        charts.push(drawn(chart("Forces", ("force", "N")), runs, &[fed_back, hand, tissue], 1.0));
    } else {
        charts.push(drawn(chart("Force fed back to the master", ("force", "N")), runs, &[fed_back], 1.0));
        charts.push(drawn(chart("Force on the hand", ("force", "N")), runs, &[hand], 1.0));
        charts.push(drawn(chart("Force of the tissue on the needle", ("force", "N")), runs, &[tissue], 1.0));
    }
    for (title, y, quantity) in [
        (
            "Estimated stiffness",
            ("stiffness", "N/m"),
            ("stiffness", (|run| &run.trace.stiffness_n_per_m) as fn(&Run) -> &[f64]),
        ),
        ("Estimated damping", ("damping", "N·s/m"), ("damping", |run| &run.trace.damping_n_s_per_m)),
    ] {
        charts.push(bounded(drawn(chart(title, y), runs, &[quantity], 1.0), 0.995));
    }
    if let Some(name) = runs.iter().find_map(|run| run.trace.extra_parameter.as_ref().map(|(name, _)| *name)) {
        let (title, y) = further(name);
        let column: Quantity<'_> =
            (y.0, |run| run.trace.extra_parameter.as_ref().map_or(&[][..], |(_, column)| column.as_slice()));
        charts.push(bounded(drawn(chart(title, y), runs, &[column], 1.0), 0.995));
    }
    let residual: Quantity<'_> = ("residual", |run| &run.trace.residual_n);
    charts.push(drawn(chart("Residual: measured less estimated force", ("residual", "N")), runs, &[residual], 1.0));
    let unit = runs.first().map_or("", |run| decision_unit(run.scenario.detector.distance.kind.unit()));
    let mut thresholds: Vec<f64> = runs.iter().map(|run| run.scenario.detector.cusum.threshold).collect();
    thresholds.sort_by(f64::total_cmp);
    thresholds.dedup();
    let decision: Quantity<'_> = ("decision", |run| &run.trace.decision);
    let decision = drawn(chart("Decision function and its threshold", ("decision", unit)), runs, &[decision], 1.0);
    charts.push(thresholded(decision, &thresholds));
    charts.into_iter().map(Chart::described).collect()
}

/// Whether so many runs leave no room for alarms, modes and names in the charts; the line of events has them.
pub(super) fn is_crowded(runs: usize) -> bool {
    runs > 2
}

/// What is marked and shaded in all charts.
fn extras(runs: &[&Run]) -> Extras {
    let is_crowded = is_crowded(runs.len());
    let mut marks: Vec<Mark> = vec![];
    let mut shades = vec![];
    for run in runs {
        let happened = events::happenings(run);
        for mark in happened.marks {
            if is_crowded && mark.kind != "rupture" {
                continue;
            }
            let label = if mark.kind == "rupture" && !is_crowded { mark.label } else { String::new() };
            let mark = Mark { label, ..mark };
            // A recording's ruptures are those of every run of it.
            if !marks.contains(&mark) {
                marks.push(mark);
            }
        }
        if !is_crowded {
            shades.extend(happened.shades);
        }
    }
    Extras { shades, marks, thresholds: vec![] }
}

/// The decision function's unit as an axis shows it.
pub(super) fn decision_unit(unit: &'static str) -> &'static str {
    if unit == "1" { "" } else { unit }
}

/// Title, name and unit of what is estimated besides.
pub(super) fn further(column: &str) -> (&'static str, (&'static str, &'static str)) {
    if column == "power" { ("Estimated power", ("power", "")) } else { ("Estimated friction", ("friction", "N")) }
}

/// A chart with the quantities of runs: a colour a run where there are several, a colour a quantity of one alone.
fn drawn(mut chart: Chart, runs: &[&Run], quantities: &[Quantity<'_>], factor: f64) -> Chart {
    for (place, run) in runs.iter().enumerate() {
        let columns: Vec<&[f64]> = quantities.iter().map(|(_, column)| column(run)).collect();
        if run.trace.is_empty() || columns.iter().any(|column| column.len() != run.trace.len()) {
            continue;
        }
        let near = events::close(&events::happenings(run).marks);
        let rows = kept(&run.trace.time_s, &columns, &near, stretches(runs.len()));
        chart.columns.push(Columns::rows(&run.trace.time_s, &columns, &rows, factor));
        for (index, (name, _)) in quantities.iter().enumerate() {
            let series = match (runs.len(), quantities.len()) {
                (1, 1) => Series::line(*name, "blue"),
                (1, _) => alone(name),
                (_, 1) => Series { width: 2.25, ..Series::line(&run.scenario.name, COLOURS[place]) },
                (2, _) => {
                    let label = format!("{name}, {}", run.scenario.name);
                    if index == 0 { Series::line(label, COLOURS[place]) } else { second(label, place) }
                }
                _ => {
                    let line = Series::line(format!("{name}, {}", run.scenario.name), COLOURS[place]);
                    if index == 0 { line } else { Series { show: false, width: 1.5, ..line.dashed() } }
                }
            };
            chart.series.push(series);
        }
    }
    let is_beyond = |column: &Columns| column.y.iter().flatten().any(|value| value.0.abs() > PLAUSIBLE);
    if matches!(chart.y.unit, "N" | "mm") && chart.columns.iter().any(is_beyond) {
        return bounded(chart, 0.95);
    }
    chart
}

/// The line of a quantity of a run that is alone.
fn alone(name: &str) -> Series {
    match name {
        "slave" | "fed back" => Series::line(name, "vermilion"),
        "tissue" => Series { width: 4.0, ..Series::line(name, "sky") },
        _ => Series::line(name, "blue").dashed(),
    }
}

/// The line of a pair's second quantity.
fn second(label: String, place: usize) -> Series {
    Series { width: 1.75, ..Series::line(label, ["sky", "orange"][place.min(1)]).dashed() }
}

/// A chart whose ordinate holds a share of its values; what few values are beyond is cut off.
pub(super) fn bounded(mut chart: Chart, share: f64) -> Chart {
    let columns = chart.columns.iter().flat_map(|columns| columns.y.iter().flatten());
    let mut values: Vec<f64> = columns.map(|value| value.0).filter(|value| value.is_finite()).collect();
    values.sort_by(f64::total_cmp);
    let Some(last) = values.len().checked_sub(1) else { return chart };
    let at = |share: f64| values[(share * last as f64) as usize];
    let (low, high) = (at(0.5 * (1.0 - share)), at(0.5 * (1.0 + share)));
    if low < high {
        let room = 0.05 * (high - low);
        chart.range = Some([Few(low - room), Few(high + room)]);
    }
    chart
}

/// A chart with thresholds, which its ordinate shows with 0.
pub(super) fn thresholded(mut chart: Chart, thresholds: &[f64]) -> Chart {
    chart.extras.thresholds = thresholds.iter().map(|value| Level { value: Few(*value) }).collect();
    chart.includes = thresholds.iter().map(|value| Few(1.15 * value)).chain([Few(0.0)]).collect();
    chart
}
