//! The root locus: the poles of the closed loop over a parameter.

use super::FigureError;
use trocar_document::figure::{Axis, BLACK, Figure, GREY, LIMIT, Panel, Row, Sample, Stroke, X_TICKS, Y_TICKS};
use trocar_lti::Complex64;
use trocar_stability::Locus;

/// The drawn range relative to the largest dominant pole, and its minimum in 1/s.
const REACH: f64 = 5.0;
const MIN_REACH: f64 = 20.0;

/// Draws the slow poles in the upper half plane. The poles of the first value are marked.
pub fn locus(name: &str, locus: &Locus, tick_s: f64) -> Result<Figure<'static>, FigureError> {
    let size = |pole: &(f64, f64)| pole.0.hypot(pole.1);
    // Poles as `s` in 1/s.
    let finite = |poles: &[Complex64]| -> Vec<(f64, f64)> {
        let continuous = poles.iter().filter(|z| z.norm() > 0.0).map(|z| z.ln() / tick_s).map(|s| (s.re, s.im));
        continuous.filter(|pole| pole.0.is_finite() && pole.1.is_finite() && pole.1 >= 0.0).collect()
    };
    // The rightmost pole of each value determines the range.
    let dominant = |poles: &[Complex64]| finite(poles).into_iter().max_by(|a, b| a.0.total_cmp(&b.0));
    let reach = locus.branches.iter().filter_map(|(_, poles)| dominant(poles)).map(|pole| size(&pole));
    let Some(reach) = reach.reduce(f64::max) else { return Err(FigureError::Empty { figure: "locus" }) };
    let reach = (REACH * reach).max(MIN_REACH);
    let [first, others] = [(BLACK, 3.6), (GREY, 1.6)].map(|(color, width)| Stroke::solid(color, width));
    let mut curves = vec![(vec![(0.0, 0.0), (0.0, reach)], LIMIT)];
    for (at, (_, poles)) in locus.branches.iter().enumerate().rev() {
        let stroke = if at == 0 { first } else { others };
        let shown = finite(poles).into_iter().filter(|pole| -reach <= pole.0 && pole.0 <= reach && pole.1 <= reach);
        curves.extend(shown.map(|pole| (vec![pole], stroke)));
    }
    let right = locus.branches.iter().flat_map(|(_, poles)| finite(poles)).map(|pole| pole.0).fold(0.0, f64::max);
    let x = Axis::exact((-reach, (0.2 * reach).max(1.1 * right.min(reach))), X_TICKS);
    let panel = Panel { curves, ..Panel::new(x, "Re s (1/s)", Axis::exact((0.0, reach), Y_TICKS), "Im s (1/s)") };
    let [Some((from, _)), Some((to, _))] = [locus.branches.first(), locus.branches.last()] else {
        return Err(FigureError::Empty { figure: "locus" });
    };
    let legend = vec![
        (Sample::Dot(first), format!("{}: {from}", locus.parameter.caption())),
        (Sample::Dot(others), format!("up to {to}")),
        (Sample::Line(LIMIT), "limit of stability".to_owned()),
    ];
    Ok(Figure { name: name.to_owned(), legend, rows: vec![Row::of(205.0, panel)] })
}
