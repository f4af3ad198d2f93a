use std::fmt::Write as _;

use anstyle::{AnsiColor, Style};
use textplots::{Chart, LabelBuilder, LabelFormat, Plot, Shape, TickDisplay, TickDisplayBuilder};

use trocar_document::Figure;
use trocar_document::figure::Axis;

/// Width and height in dots. A character has two by four dots.
const DOTS: (u32, u32) = (120, 36);

/// The colours of the rows, repeated.
const COLOURS: [AnsiColor; 4] = [AnsiColor::Blue, AnsiColor::Yellow, AnsiColor::Cyan, AnsiColor::Magenta];

/// The first signal of each row as a chart, with ANSI colours.
pub fn sketch(figure: &Figure<'_>) -> String {
    let mut text = String::new();
    for (index, row) in figure.rows.iter().enumerate() {
        let Some((panel, series)) = row.panels.first().and_then(|panel| Some((panel, panel.series.first()?))) else {
            continue;
        };
        let is_within = |at: f64, axis: &Axis| (axis.low..=axis.high).contains(&at);
        let is_shown = |(x, y): &(f64, f64)| is_within(*x, &panel.x) && is_within(*y, &panel.y);
        let samples = panel.samples(series, DOTS.0 as usize, &[]).filter(is_shown);
        let points: Vec<(f32, f32)> = samples.map(|(x, y)| (x as f32, y as f32)).collect();
        let style = Style::new().fg_color(Some(COLOURS[index % COLOURS.len()].into()));
        let shape = Shape::Lines(&points);
        let [left, right, low, high] = [panel.x.low, panel.x.high, panel.y.low, panel.y.high].map(|end| end as f32);
        let mut chart = Chart::new_with_y_range(DOTS.0, DOTS.1, left, right, low, high);
        let chart = chart
            .x_label_format(LabelFormat::Custom(Box::new(|x| format!("{x:.2}"))))
            .y_label_format(LabelFormat::Custom(Box::new(|y| format!("{y:.1}"))))
            .y_tick_display(TickDisplay::Sparse)
            .lineplot(&shape);
        chart.figures();
        let _ = writeln!(text, "{style}{}{style:#}", row.title.as_deref().unwrap_or_default());
        for line in chart.to_string().lines() {
            let _ = writeln!(text, "{style}{}{style:#}", line.trim_end());
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use trocar_document::Study as _;
    use trocar_scenario::{Scenario, Source};
    use trocar_studies::compare::{Comparison, ComparisonReport};

    #[test]
    fn an_overshoot_is_steep_and_a_frozen_slave_is_flat() {
        let shipped = |name: &str| Scenario::load(&Source::parse(name), &[]).expect("good");
        let comparison = Comparison::of(["paper/classical", "paper/augmented"].map(shipped).to_vec()).expect("runs");
        let report = ComparisonReport { comparison: &comparison, facts: None, seeds: None };
        let document = report.document();
        let text = sketch(document.sketch.as_ref().expect("described"));
        let text = anstream::adapter::strip_str(&text).to_string();
        let charts: Vec<&str> = text.split("slave position around rupture 1, in mm over s").collect();
        assert_eq!(charts.len(), 3);
        // The row of the line 0.4 s after the rupture, with a frozen augmented slave; 30 columns are one second.
        let row = |chart: &str| {
            let has_dots = |line: &&str| line.chars().nth(27).is_some_and(|c| ('\u{2801}'..='\u{28ff}').contains(&c));
            chart.lines().skip(1).position(|line| has_dots(&line)).expect("a line")
        };
        assert!(row(charts[1]) < 2 && row(charts[2]) > 6, "{text}");
        assert!(text.lines().all(|line| line.chars().count() <= 80), "{text}");
    }
}
