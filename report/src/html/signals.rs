//! The charts of runs over time.

use super::chart::{COLOURS, Chart, ChartAxis, Columns, Extras, Level, Mark, Series};
use super::events;
use crate::decimate::kept;
use crate::digits::Few;
use crate::figures::STANDARD_ERRORS;
use trocar_sim::engine::TrustColumns;
use trocar_sim::run::Run;

/// Maximum number of runs in the charts.
pub(super) const MAX_RUNS: usize = 8;

/// Number of intervals of all runs together, which keeps a page below 2 MB.
const INTERVALS: usize = 1_300;

/// A force (N) and a position (mm) that no needle insertion reaches.
const PLAUSIBLE: f64 = 1e3;

/// The estimated parameters: title, name and unit of their charts.
pub(super) const PARAMETERS: [(&str, (&str, &str)); 2] =
    [("Estimated stiffness", ("stiffness", "N/m")), ("Estimated damping", ("damping", "N·s/m"))];

/// A quantity of a trace: its name and its column.
type Quantity<'a> = (&'a str, fn(&Run) -> &[f64]);

/// Returns the number of intervals of each run.
pub(super) fn intervals_per_run(runs: usize) -> usize {
    INTERVALS / runs.max(2)
}

/// Returns the charts of a run, or of several runs in the same axes.
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
    let feedback: Quantity<'_> = ("feedback force", |run| &run.trace.feedback_force_n);
    let operator: Quantity<'_> = ("felt force", |run| &run.trace.operator_force_n);
    let tissue: Quantity<'_> = ("tissue force", |run| &run.trace.tissue_force_n);
    if let [_] = runs {
        charts.push(drawn(chart("Forces", ("force", "N")), runs, &[feedback, operator, tissue], 1.0));
    } else {
        charts.push(drawn(chart("Feedback force", ("force", "N")), runs, &[feedback], 1.0));
        charts.push(drawn(chart("Force of the operator on the master", ("force", "N")), runs, &[operator], 1.0));
        charts.push(drawn(chart("Tissue force on the needle", ("force", "N")), runs, &[tissue], 1.0));
    }
    charts.extend(parameters(|title, y| chart(title, y), runs));
    if let Some(name) = runs.iter().find_map(|run| run.trace.extra_parameter.as_ref().map(|(name, _)| *name)) {
        let (title, y) = extra_parameter_axis(name);
        let column: Quantity<'_> =
            (y.0, |run| run.trace.extra_parameter.as_ref().map_or(&[][..], |(_, column)| column.as_slice()));
        charts.push(bounded(drawn(chart(title, y), runs, &[column], 1.0), 0.995));
    }
    let residual: Quantity<'_> = ("residual", |run| &run.trace.residual_n);
    charts.push(drawn(chart("Residual: measured minus estimated force", ("residual", "N")), runs, &[residual], 1.0));
    let unit = runs.first().map_or("", |run| decision_unit(run.scenario.detector.distance.kind.unit()));
    let mut thresholds: Vec<f64> = runs.iter().map(|run| run.scenario.detector.cusum.threshold).collect();
    thresholds.sort_by(f64::total_cmp);
    thresholds.dedup();
    let decision: Quantity<'_> = ("decision", |run| &run.trace.decision);
    let decision = drawn(chart("Decision function and its threshold", ("decision", unit)), runs, &[decision], 1.0);
    charts.push(thresholded(decision, &thresholds));
    charts.into_iter().map(Chart::described).collect()
}

/// Returns the charts of the estimated stiffness and damping, with the band of the standard errors for a single run.
fn parameters(chart: impl Fn(&str, (&str, &'static str)) -> Chart, runs: &[&Run]) -> [Chart; 2] {
    let estimates: [fn(&Run) -> &[f64]; 2] = [|run| &run.trace.stiffness_n_per_m, |run| &run.trace.damping_n_s_per_m];
    let errors: [fn(&TrustColumns) -> &[f64]; 2] =
        [|trust| &trust.stiffness_std_n_per_m, |trust| &trust.damping_std_n_s_per_m];
    std::array::from_fn(|k| {
        let (title, y) = PARAMETERS[k];
        if let [run] = runs
            && let Some(trust) = &run.trace.trust
        {
            let detailed = events::detailed_intervals(&events::of_run(run).marks);
            return estimate(chart(title, y), &run.trace.time_s, (estimates[k](run), errors[k](trust)), &detailed);
        }
        bounded(drawn(chart(title, y), runs, &[(y.0, estimates[k])], 1.0), 0.995)
    })
}

/// Returns the chart of an estimate over time with the band of its standard errors. The axis is that of the estimate.
pub(super) fn estimate(mut chart: Chart, time_s: &[f64], (y, std): (&[f64], &[f64]), detailed: &[(f64, f64)]) -> Chart {
    let edge = |sign: f64| -> Vec<f64> { y.iter().zip(std).map(|(y, std)| y + sign * STANDARD_ERRORS * std).collect() };
    let (upper, lower) = (edge(1.0), edge(-1.0));
    let columns = [y, &upper, &lower];
    let rows = kept(time_s, &columns, detailed, intervals_per_run(1));
    chart.columns.push(Columns::rows(time_s, &columns, &rows, 1.0));
    chart.series.push(Series::line(chart.y.label.clone(), "blue"));
    chart.series.extend(Series::edges(&format!("{STANDARD_ERRORS} standard errors"), "blue"));
    bounded(chart, 0.995)
}

/// Returns whether the charts of this many runs omit alarms, modes and names. The timeline shows them.
pub(super) fn is_crowded(runs: usize) -> bool {
    runs > 2
}

/// Returns the marks and shades of all charts.
fn extras(runs: &[&Run]) -> Extras {
    let is_crowded = is_crowded(runs.len());
    let mut marks: Vec<Mark> = vec![];
    let mut shades = vec![];
    for run in runs {
        let events = events::of_run(run);
        for mark in events.marks {
            if is_crowded && mark.kind != "rupture" {
                continue;
            }
            let label = if mark.kind == "rupture" && !is_crowded { mark.label } else { String::new() };
            let mark = Mark { label, ..mark };
            // Runs of the same recording have the same ruptures.
            if !marks.contains(&mark) {
                marks.push(mark);
            }
        }
        if !is_crowded {
            shades.extend(events.shades);
        }
    }
    Extras { shades, marks, thresholds: vec![] }
}

/// Returns the unit of the decision function for an axis.
pub(super) fn decision_unit(unit: &'static str) -> &'static str {
    if unit == "1" { "" } else { unit }
}

/// Returns the title, name and unit of the estimator's extra parameter.
pub(super) fn extra_parameter_axis(column: &str) -> (&'static str, (&'static str, &'static str)) {
    if column == "power" { ("Estimated power", ("power", "")) } else { ("Estimated friction", ("friction", "N")) }
}

/// Returns a chart with the quantities of runs. Several runs have one colour per run; a single run has one colour per quantity.
fn drawn(mut chart: Chart, runs: &[&Run], quantities: &[Quantity<'_>], factor: f64) -> Chart {
    for (place, run) in runs.iter().enumerate() {
        let columns: Vec<&[f64]> = quantities.iter().map(|(_, column)| column(run)).collect();
        if run.trace.is_empty() || columns.iter().any(|column| column.len() != run.trace.len()) {
            continue;
        }
        let detailed = events::detailed_intervals(&events::of_run(run).marks);
        let rows = kept(&run.trace.time_s, &columns, &detailed, intervals_per_run(runs.len()));
        chart.columns.push(Columns::rows(&run.trace.time_s, &columns, &rows, factor));
        for (index, (name, _)) in quantities.iter().enumerate() {
            let series = match (runs.len(), quantities.len()) {
                (1, 1) => Series::line(*name, "blue"),
                (1, _) => of_single_run(name, run),
                (_, 1) => Series { width: 2.25, ..Series::line(&run.scenario.name, COLOURS[place]) },
                (2, _) => {
                    let label = format!("{name}, {}", run.scenario.name);
                    if index == 0 { Series::line(label, COLOURS[place]) } else { second_of_pair(label, place) }
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

/// Returns the line of a quantity of a single run, in the colours of the figures: that of its control, of the tissue or of the hand.
fn of_single_run(name: &str, run: &Run) -> Series {
    match name {
        "slave" | "feedback force" if run.scenario.augmentation.enabled => Series::line(name, "vermilion"),
        "slave" | "feedback force" => Series::line(name, "blue"),
        "tissue force" => Series { width: 4.0, ..Series::line(name, "sky") },
        _ => Series::line(name, "green").dashed(),
    }
}

/// Returns the line of the second quantity in the chart of a pair of runs.
fn second_of_pair(label: String, place: usize) -> Series {
    Series { width: 1.75, ..Series::line(label, ["sky", "orange"][place.min(1)]).dashed() }
}

/// Returns the chart with a vertical axis that contains a central share of the values of its lines. Values beyond are cut off.
pub(super) fn bounded(mut chart: Chart, share: f64) -> Chart {
    let columns = chart.columns.iter().flat_map(|columns| &columns.y).zip(&chart.series);
    let lines = columns.filter(|(_, series)| !series.edge).flat_map(|(column, _)| column);
    let mut values: Vec<f64> = lines.map(|value| value.0).filter(|value| value.is_finite()).collect();
    values.sort_by(f64::total_cmp);
    let Some(last) = values.len().checked_sub(1) else { return chart };
    let at = |share: f64| values[(share * last as f64) as usize];
    let (low, high) = (at(0.5 * (1.0 - share)), at(0.5 * (1.0 + share)));
    if low < high {
        let margin = 0.05 * (high - low);
        chart.range = Some([Few(low - margin), Few(high + margin)]);
    }
    chart
}

/// Returns the chart with thresholds and a vertical axis that includes 0 and the thresholds.
pub(super) fn thresholded(mut chart: Chart, thresholds: &[f64]) -> Chart {
    chart.extras.thresholds = thresholds.iter().map(|value| Level { value: Few(*value) }).collect();
    chart.includes = thresholds.iter().map(|value| Few(1.15 * value)).chain([Few(0.0)]).collect();
    chart
}
