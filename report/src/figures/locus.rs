//! The root locus: the poles of the closed loop over a parameter.

use super::axis::{Axis, X_TICKS, Y_TICKS};
use super::grid::{Grid, Row, Sample};
use super::panel::Panel;
use super::style::{BLUE, GREY, Stroke, VERMILION};
use super::{Figure, FigureError};

/// The range that is drawn, relative to the slowest pole of any value, and its minimum in 1/s.
const REACH: f64 = 5.0;
const MIN_REACH: f64 = 20.0;

/// The poles over a parameter, as `s` in 1/s.
#[derive(Clone, Debug)]
pub struct LocusView {
    /// The parameter's name with its unit.
    pub caption: String,
    /// Each value with its poles `(Re s, Im s)`.
    pub branches: Vec<(f64, Vec<(f64, f64)>)>,
}

/// Draws the slow poles of the upper half plane, and those of the first value marked.
///
/// # Errors
/// [`FigureError::Empty`] without poles.
pub fn locus(view: &LocusView) -> Result<Figure, FigureError> {
    let size = |pole: &(f64, f64)| pole.0.hypot(pole.1);
    let finite = |poles: &[(f64, f64)]| -> Vec<(f64, f64)> {
        poles.iter().copied().filter(|pole| pole.0.is_finite() && pole.1.is_finite() && pole.1 >= 0.0).collect()
    };
    // The pole nearest to the right decides; the others are drawn around it.
    let dominant = |poles: &[(f64, f64)]| finite(poles).into_iter().max_by(|a, b| a.0.total_cmp(&b.0));
    let reach = view.branches.iter().filter_map(|(_, poles)| dominant(poles)).map(|pole| size(&pole));
    let Some(reach) = reach.reduce(f64::max) else { return Err(FigureError::Empty { figure: "locus" }) };
    let reach = (REACH * reach).max(MIN_REACH);
    let [first, others, limit] =
        [(VERMILION, 8.0), (BLUE, 5.0), (GREY, 2.0)].map(|(color, width)| Stroke::solid(color, width));
    let mut curves = vec![(vec![(0.0, 0.0), (0.0, reach)], limit)];
    for (at, (_, poles)) in view.branches.iter().enumerate().rev() {
        let stroke = if at == 0 { first } else { others };
        let shown = finite(poles).into_iter().filter(|pole| -reach <= pole.0 && pole.0 <= reach && pole.1 <= reach);
        curves.extend(shown.map(|pole| (vec![pole], stroke)));
    }
    let right = view.branches.iter().flat_map(|(_, poles)| finite(poles)).map(|pole| pole.0).fold(0.0, f64::max);
    let panel = Panel {
        x_caption: "Re s (1/s)",
        curves,
        ..Panel::over_time(
            Axis::exact((-reach, (0.2 * reach).max(1.1 * right.min(reach))), X_TICKS),
            Axis::exact((0.0, reach), Y_TICKS),
            "Im s (1/s)",
        )
    };
    let [Some((from, _)), Some((to, _))] = [view.branches.first(), view.branches.last()] else {
        return Err(FigureError::Empty { figure: "locus" });
    };
    let legend = vec![
        (Sample::Line(first), format!("poles at {} = {from}", view.caption)),
        (Sample::Line(others), format!("up to {to}")),
        (Sample::Line(limit), "limit of stability".to_owned()),
    ];
    let rows = vec![Row { title: None, height: 640.0, panels: vec![panel] }];
    Grid { legends: vec![legend], common: vec![], rows }.draw()
}
