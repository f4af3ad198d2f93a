//! The influence of each axis on each metric, as bars.

use super::FigureError;
use trocar_document::figure::{Axis, BLACK, Color, Figure, GREY, GUIDE, Panel, Point, Row, Sample, X_TICKS};

/// Maximum number of bars in one figure.
const MAX_BARS: usize = 100;

/// A metric with the influence of each axis, the strongest first.
#[derive(Clone, Debug)]
pub struct TornadoView<'a> {
    /// The metric.
    pub metric: &'a str,
    /// Its bars.
    pub bars: Vec<Bar>,
}

/// The title of an axis, its first-order Sobol index (0 to 1) and its standardised rank regression coefficient (-1 to 1).
pub type Bar = (String, Option<f64>, Option<f64>);

/// The colours of the two bars.
const SLOPE: Color = BLACK;
const SHARE: Color = GREY.pale(0.45);

/// Draws two bars per metric and axis: the rank regression coefficient above, the first-order Sobol index below.
///
/// # Errors
/// [`FigureError::Empty`] without a bar.
pub fn tornado(name: &str, views: &[TornadoView<'_>]) -> Result<Figure<'static>, FigureError> {
    let bars = views.iter().flat_map(|view| view.bars.iter().map(|bar| (view.metric, bar)));
    let bar = |value: f64, (low, high): (f64, f64)| -> Vec<Point> {
        let value = value.clamp(-1.05, 1.05);
        vec![(0.0, low), (value, low), (value, high), (0.0, high)]
    };
    let row = |(metric, (axis, index, slope)): (&str, &Bar)| {
        let slope = slope.map(|slope| (bar(slope, (0.5, 0.9)), SLOPE));
        let index = index.map(|index| (bar(index, (0.1, 0.5)), SHARE));
        let panel = Panel {
            fills: slope.into_iter().chain(index).collect(),
            curves: vec![(vec![(0.0, 0.0), (0.0, 1.0)], GUIDE)],
            ..Panel::new(Axis::exact((-1.05, 1.05), X_TICKS), "Influence", Axis::exact((0.0, 1.0), 0), "")
        };
        Row { title: Some(format!("{metric}: {axis}")), ..Row::of(14.0, panel) }
    };
    let rows: Vec<Row<'_>> = bars.take(MAX_BARS).map(row).collect();
    if rows.is_empty() {
        return Err(FigureError::Empty { figure: "tornado" });
    }
    let legend = [
        (SLOPE, "standardised rank regression coefficient (to the right: increases with the axis)"),
        (SHARE, "first-order Sobol index"),
    ];
    Ok(Figure {
        name: name.to_owned(),
        legend: legend.map(|(color, text)| (Sample::Shade(color), text.to_owned())).into(),
        rows,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shown;

    #[test]
    fn every_axis_of_every_metric_has_its_bars() {
        let bars = vec![("scaling.force".to_owned(), Some(0.8), Some(-0.9)), ("arm.grip".to_owned(), Some(0.1), None)];
        let views =
            [TornadoView { metric: "overshoot", bars }, TornadoView { metric: "delay", bars: vec![("x".to_owned(), None, None)] }];
        let text = shown(&tornado("sweep", &views).expect("drawn"));
        for title in ["overshoot: scaling.force", "overshoot: arm.grip", "delay: x"] {
            assert!(text.contains(&format!("\"{title}\"")), "{title}");
        }
        assert!(matches!(tornado("", &[]), Err(FigureError::Empty { .. })));
    }
}
