//! The strategies of a study: excess advance against the share of noticed ruptures.

use super::FigureError;
use trocar_document::figure::{
    Axis, BLACK, BLUE, Color, Entry, Figure, GREEN, GREY, ORANGE, PURPLE, Panel, Point, Row, SKY, Sample, Stroke,
    VERMILION, WHITE, X_TICKS, Y_TICKS,
};

/// The colours of the dots; the next strategies have the same colours and rings.
const COLORS: [Color; 8] = [BLACK, BLUE, ORANGE, GREEN, VERMILION, SKY, PURPLE, GREY];

const FRONT: Stroke = Stroke::dashed(GREY, 1.0, &[3.0, 2.5]);

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
pub fn strategies(name: &str, views: &[StrategyView<'_>]) -> Result<Figure<'static>, FigureError> {
    if views.is_empty() {
        return Err(FigureError::Empty { figure: "strategies" });
    }
    let at = |view: &StrategyView<'_>| -> Point { (1e3 * view.excess_m, 100.0 * view.noticed) };
    // Dots at the same place are inside each other.
    let dot = |index: usize| Stroke::solid(COLORS[index % COLORS.len()], (7.5 - 0.35 * index as f64).max(3.0));
    let is_ring = |index: usize| index >= COLORS.len();
    let mut front: Vec<Point> = views.iter().filter(|view| view.is_on_front).map(at).collect();
    front.sort_by(|a, b| a.0.total_cmp(&b.0));
    let high = views.iter().map(|view| at(view).0).fold(0.0, f64::max);
    let low = views.iter().map(|view| at(view).1).fold(100.0, f64::min);
    let (x, y) = (Axis::from_zero(high, X_TICKS), Axis::padded((low, 100.0), Y_TICKS));
    let mut panel = Panel::new(x, "Mean excess advance (mm)", y, "Noticed ruptures (%)");
    if front.len() > 1 {
        panel.curves.push((front, FRONT));
    }
    panel.curves.extend(views.iter().enumerate().flat_map(|(index, view)| {
        let hole = Stroke { color: WHITE, width: 0.5 * dot(index).width, ..dot(index) };
        let hole = is_ring(index).then(|| (vec![at(view)], hole));
        std::iter::once((vec![at(view)], dot(index))).chain(hole)
    }));
    let entry = |(index, view): (usize, &StrategyView<'_>)| -> Entry {
        (if is_ring(index) { Sample::Ring(dot(index)) } else { Sample::Dot(dot(index)) }, view.name.to_owned())
    };
    let mut legend: Vec<Entry> = views.iter().enumerate().map(entry).collect();
    legend.push((Sample::Line(FRONT), "Pareto front".to_owned()));
    Ok(Figure { name: name.to_owned(), legend, rows: vec![Row::of(200.0, panel)] })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shown;

    #[test]
    fn every_strategy_is_in_the_legend() {
        let view = |name, excess_m, is_on_front| StrategyView { name, excess_m, noticed: 0.5, is_on_front };
        let views = [view("none", 5e-3, false), view("cue", 0.0, true)];
        let text = shown(&strategies("skin", &views).expect("drawn"));
        for name in ["none", "cue", "Pareto front", "Noticed ruptures (%)"] {
            assert!(text.contains(&format!("\"{name}\"")), "{name}");
        }
        assert!(matches!(strategies("", &[]), Err(FigureError::Empty { .. })));
    }
}
