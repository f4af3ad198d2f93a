//! The strategies of a study: excess advance against the share of noticed ruptures.

use plotters::style::RGBColor;

use super::axis::{Axis, X_TICKS, Y_TICKS};
use super::grid::{Entry, Grid, Row, Sample};
use super::panel::Panel;
use super::style::{BLACK, BLUE, GREEN, GREY, ORANGE, PURPLE, SKY, Stroke, VERMILION};
use super::thin::Point;
use super::{Figure, FigureError};

/// The colours of the dots; the next strategies have the same colours and smaller dots.
const COLORS: [RGBColor; 8] = [BLACK, BLUE, ORANGE, GREEN, VERMILION, SKY, PURPLE, GREY];

const FRONT: Stroke = Stroke { color: GREY, width: 3.0, dashes: &[10.0, 8.0] };

/// A strategy.
#[derive(Clone, Copy, Debug)]
pub struct StrategyView<'a> {
    /// Its name.
    pub name: &'a str,
    /// Mean excess advance, m.
    pub excess_m: f64,
    /// Share of the noticed ruptures, 0 to 1.
    pub noticed: f64,
    /// Whether it is on the Pareto front.
    pub is_on_front: bool,
}

/// Draws a dot per strategy, and the Pareto front as a line. Better is to the left and up.
///
/// # Errors
/// [`FigureError::Empty`] without a strategy.
pub fn strategies(views: &[StrategyView<'_>]) -> Result<Figure, FigureError> {
    if views.is_empty() {
        return Err(FigureError::Empty { figure: "strategies" });
    }
    let at = |view: &StrategyView<'_>| -> Point { (1e3 * view.excess_m, 100.0 * view.noticed) };
    let dot =
        |index: usize| Stroke::solid(COLORS[index % COLORS.len()], if index < COLORS.len() { 26.0 } else { 16.0 });
    let mut front: Vec<Point> = views.iter().filter(|view| view.is_on_front).map(at).collect();
    front.sort_by(|a, b| a.0.total_cmp(&b.0));
    let high = views.iter().map(|view| at(view).0).fold(0.0, f64::max);
    let low = views.iter().map(|view| at(view).1).fold(100.0, f64::min);
    let mut panel = Panel {
        x_caption: "Mean excess advance (mm)",
        ..Panel::over_time(
            Axis::from_zero(if high > 0.0 { high } else { 1.0 }, X_TICKS),
            Axis::padded((low, 100.0), Y_TICKS),
            "Noticed (%)",
        )
    };
    if front.len() > 1 {
        panel.curves.push((front, FRONT));
    }
    panel.curves.extend(views.iter().enumerate().map(|(index, view)| (vec![at(view)], dot(index))));
    let entry =
        |(index, view): (usize, &StrategyView<'_>)| -> Entry { (Sample::Dot(dot(index)), view.name.to_owned()) };
    let mut legend: Vec<Entry> = views.iter().enumerate().map(entry).collect();
    legend.push((Sample::Line(FRONT), "Pareto front".to_owned()));
    Grid { legends: vec![legend], common: vec![], rows: vec![Row { title: None, height: 760.0, panels: vec![panel] }] }
        .draw()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_strategy_is_in_the_legend() {
        let view = |name, excess_m, is_on_front| StrategyView { name, excess_m, noticed: 0.5, is_on_front };
        let figure = strategies(&[view("none", 5e-3, false), view("cue", 0.0, true)]).expect("drawn");
        for name in ["none", "cue", "Pareto front", "Noticed (%)"] {
            assert!(figure.svg.contains(&format!("\n{name}\n")), "{name}");
        }
        assert!(matches!(strategies(&[]), Err(FigureError::Empty { .. })));
    }
}
