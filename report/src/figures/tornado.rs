//! The influence of each axis on each metric, as bars.

use plotters::style::{Color, RGBAColor};

use super::axis::{Axis, X_TICKS};
use super::grid::{Grid, Row, Sample};
use super::panel::Panel;
use super::style::{BLUE, GREY, SKY, Stroke, VERMILION};
use super::thin::Point;
use super::{Figure, FigureError};

/// Maximum number of bars in one figure.
const MAX_BARS: usize = 100;

/// A metric with the influence of each axis, the strongest first.
#[derive(Clone, Debug)]
pub struct TornadoView<'a> {
    /// The metric.
    pub metric: &'a str,
    /// By axis: its name, first-order Sobol index (0 to 1) and standardised rank regression coefficient (-1 to 1).
    pub bars: Vec<(&'a str, Option<f64>, Option<f64>)>,
}

/// Draws two bars per metric and axis: the rank regression coefficient above, the first-order Sobol index below.
///
/// # Errors
/// [`FigureError::Empty`] without a bar.
pub fn tornado(views: &[TornadoView<'_>]) -> Result<Figure, FigureError> {
    let titled: Vec<(String, Option<f64>, Option<f64>)> = views
        .iter()
        .flat_map(|view| view.bars.iter().map(|bar| (format!("{}: {}", view.metric, bar.0), bar.1, bar.2)))
        .take(MAX_BARS)
        .collect();
    if titled.is_empty() {
        return Err(FigureError::Empty { figure: "tornado" });
    }
    let share = Axis::exact((-1.05, 1.05), X_TICKS);
    let mut blank = Axis::exact((0.0, 1.0), 1);
    blank.ticks.clear();
    let zero = [0.0, 0.0];
    let up = [0.0, 1.0];
    let bar = |value: f64, low: f64, high: f64| -> Vec<Point> {
        let value = value.clamp(-1.05, 1.05);
        vec![(0.0, low), (value, low), (value, high), (0.0, high)]
    };
    let panel = |epsilon_squared: Option<f64>, slope: Option<f64>| {
        let mut fills: Vec<(Vec<Point>, RGBAColor)> = vec![];
        if let Some(slope) = slope {
            let color = if slope < 0.0 { BLUE } else { VERMILION };
            fills.push((bar(slope, 0.5, 0.92), color.to_rgba()));
        }
        fills.extend(epsilon_squared.map(|index| (bar(index, 0.08, 0.5), SKY.to_rgba())));
        let middle = super::panel::Trace { x: &zero, y: &up, scale: 1.0, stroke: Stroke::solid(GREY, 2.0) };
        Panel {
            x_caption: "Standardised rank regression coefficient; first-order Sobol index",
            fills,
            traces: vec![middle],
            ..Panel::over_time(share.clone(), blank.clone(), "")
        }
    };
    let rows = titled
        .iter()
        .map(|(title, epsilon_squared, slope)| Row {
            title: Some(title),
            height: 56.0,
            panels: vec![panel(*epsilon_squared, *slope)],
        })
        .collect();
    let common = vec![
        (Sample::Shade(VERMILION.to_rgba()), "rank regression: increases with the axis".to_owned()),
        (Sample::Shade(BLUE.to_rgba()), "decreases".to_owned()),
        (Sample::Shade(SKY.to_rgba()), "first-order Sobol index".to_owned()),
    ];
    Grid { legends: vec![], common, rows }.draw()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_axis_of_every_metric_has_its_bars() {
        let bars = vec![("scaling.force", Some(0.8), Some(-0.9)), ("arm.grip", Some(0.1), None)];
        let views =
            [TornadoView { metric: "overshoot", bars }, TornadoView { metric: "delay", bars: vec![("x", None, None)] }];
        let figure = tornado(&views).expect("drawn");
        for title in ["overshoot: scaling.force", "overshoot: arm.grip", "delay: x"] {
            assert!(figure.svg.contains(&format!("\n{title}\n")), "{title}");
        }
        assert!(matches!(tornado(&[]), Err(FigureError::Empty { .. })));
    }
}
