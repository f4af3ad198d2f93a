//! A small chart for the terminal: the slave's position around the first rupture.

use std::fmt::Write as _;

use anstyle::{AnsiColor, Style};
use textplots::{Chart, LabelBuilder, LabelFormat, Plot, Shape, TickDisplay, TickDisplayBuilder};

use trocar_studies::run::Run;

/// Width and height in dots. A character has two by four dots.
const DOTS: (u32, u32) = (120, 36);

/// Time shown before and after the first rupture, in s.
const AROUND_S: (f64, f64) = (0.5, 1.5);

/// Maximum number of runs with a chart.
const MAX_RUNS: usize = 4;

/// Returns one chart per run on the same axes, with ANSI colours: the slave's position around the first rupture of all runs, or
/// over the whole time without a rupture. Returns `None` without samples.
#[must_use]
pub fn runs_chart(runs: &[Run]) -> Option<String> {
    let runs: Vec<&Run> = runs.iter().filter(|run| run.trace.len() > 1).take(MAX_RUNS).collect();
    let last_s = runs.iter().filter_map(|run| run.trace.time_s.last().copied()).reduce(f64::max)?;
    let ruptures = runs.iter().filter_map(|run| run.metrics.ruptures.first()).map(|rupture| rupture.time_s);
    let first_s = ruptures.reduce(f64::min);
    let (from_s, to_s) =
        first_s.map_or((0.0, last_s), |at| ((at - AROUND_S.0).max(0.0), (at + AROUND_S.1).min(last_s)));
    let lines: Vec<(&str, Vec<(f32, f32)>)> =
        runs.iter().map(|run| (&*run.scenario.name, line(run, from_s, to_s))).collect();
    let positions = || lines.iter().flat_map(|(_, points)| points.iter().map(|(_, y)| *y));
    let (low, high) = (positions().reduce(f32::min)?, positions().reduce(f32::max)?);
    // A needle at rest has a range of 1 mm, which avoids a division by 0.
    let (low, high) = if high - low < 1e-3 { (low - 0.5, high + 0.5) } else { (low, high) };
    let mut text = String::new();
    for (index, (name, points)) in lines.iter().enumerate() {
        let style = Style::new().fg_color(Some(COLOURS[index % COLOURS.len()].into()));
        let shape = Shape::Lines(points);
        let mut chart = Chart::new_with_y_range(DOTS.0, DOTS.1, from_s as f32, to_s as f32, low, high);
        let chart = chart
            .x_label_format(LabelFormat::Custom(Box::new(|s| format!("{s:.2} s"))))
            .y_label_format(LabelFormat::Custom(Box::new(|mm| format!("{mm:.1} mm"))))
            .y_tick_display(TickDisplay::Sparse)
            .lineplot(&shape);
        chart.figures();
        let when = if first_s.is_some() { " around rupture 1" } else { "" };
        // Writing to a string does not fail.
        let _ = writeln!(text, "{style}{name}{style:#}: slave position{when}");
        for line in chart.to_string().lines() {
            let _ = writeln!(text, "{style}{}{style:#}", line.trim_end());
        }
    }
    Some(text)
}

/// The colour of each chart.
const COLOURS: [AnsiColor; MAX_RUNS] = [AnsiColor::Blue, AnsiColor::Yellow, AnsiColor::Cyan, AnsiColor::Magenta];

/// Returns the slave's position in mm in a time interval, without NaN and without implausible values.
fn line(run: &Run, from_s: f64, to_s: f64) -> Vec<(f32, f32)> {
    let trace = &run.trace;
    let points = trace.time_s.iter().zip(&trace.slave_position_m);
    let shown = points.filter(|(time_s, position_m)| (from_s..=to_s).contains(*time_s) && position_m.abs() < 10.0);
    shown.map(|(time_s, position_m)| (*time_s as f32, (1e3 * position_m) as f32)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use trocar_scenario::{Scenario, Source};
    use trocar_studies::run::run;

    fn shipped(name: &str) -> Run {
        run(Scenario::load(&Source::parse(name), &[]).expect("good")).expect("runs")
    }

    #[test]
    fn an_overshoot_is_steep_and_a_frozen_slave_is_flat() {
        let text = runs_chart(&[shipped("paper/classical"), shipped("paper/augmented")]).expect("drawn");
        let text = anstream::adapter::strip_str(&text).to_string();
        let charts: Vec<&str> = text.split("slave position around rupture 1").collect();
        assert_eq!(charts.len(), 3);
        // The row of the line 0.4 s after the rupture, while the augmented slave is frozen; 30 columns are one second.
        let row = |chart: &str| {
            let has_dots = |line: &&str| line.chars().nth(27).is_some_and(|c| ('\u{2801}'..='\u{28ff}').contains(&c));
            chart.lines().skip(1).position(|line| has_dots(&line)).expect("a line")
        };
        assert!(row(charts[1]) < 2 && row(charts[2]) > 6, "{text}");
        assert!(text.lines().all(|line| line.chars().count() <= 80), "{text}");
    }

    #[test]
    fn a_run_that_ends_at_once_has_no_chart() {
        assert_eq!(runs_chart(&[]), None);
    }
}
