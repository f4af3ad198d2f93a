//! The maximum stiffness of stable and passive walls over their damping.

use super::FigureError;
use trocar_document::figure::{Axis, Figure, GREEN, Panel, Row, SKY, Sample, Series, Stroke, X_TICKS, extent};
use trocar_stability::{Walls, ZWidth};

pub fn z_width(name: &str, z_width: &ZWidth) -> Result<Figure<'static>, FigureError> {
    let Some((low, high)) = extent(z_width.damping_n_s_per_m.iter().copied()) else {
        return Err(FigureError::Empty { figure: "z_width" });
    };
    let [tissue, virtual_wall] = [SKY, GREEN].map(|color| Stroke::solid(color, 1.2));
    let dashed = |stroke: Stroke| Stroke { dashes: &[5.0, 3.0], ..stroke };
    let column = |walls: &[Walls], of: fn(&Walls) -> Option<f64>| walls.iter().map(of).collect::<Vec<_>>();
    let of = |walls: &[Walls], place: &str, stroke: Stroke| {
        let stable = (format!("stable walls {place}"), column(walls, |one| one.stable_n_per_m), stroke);
        let passive = (format!("passive walls {place}"), column(walls, |one| one.passive_n_per_m), dashed(stroke));
        [stable, passive]
    };
    let virtual_walls = z_width.virtual_walls.iter();
    let virtual_walls = virtual_walls.flat_map(|walls| of(walls, "computed by the master", virtual_wall));
    let lines: Vec<_> = of(&z_width.tissue, "in the tissue", tissue).into_iter().chain(virtual_walls).collect();
    let is_drawn = |value: &f64| *value > 0.0 && value.is_finite();
    let points: Vec<(Vec<f64>, Vec<f64>)> = lines
        .iter()
        .map(|(_, values, _)| {
            let each = z_width.damping_n_s_per_m.iter().zip(values.iter());
            each.filter_map(|(damping, value)| Some((*damping, value.filter(is_drawn)?))).unzip()
        })
        .collect();
    let (min, max) = extent(points.iter().flat_map(|(_, y)| y.iter().copied())).unwrap_or((1.0, 10.0));
    let series = points.into_iter().zip(&lines).filter(|((x, _), _)| !x.is_empty());
    let panel = Panel {
        series: series.map(|((x, y), (_, _, stroke))| Series::new(x, y, *stroke)).collect(),
        ..Panel::new(
            Axis::exact((low, high), X_TICKS),
            "Damping of the wall (N·s/m)",
            Axis::log10((min / 1.5, 1.5 * max)),
            "Maximum stiffness of the wall (N/m)",
        )
    };
    let legend = lines.iter().map(|(name, _, stroke)| (Sample::Line(*stroke), name.clone())).collect();
    Ok(Figure { name: name.to_owned(), legend, rows: vec![Row::of(195.0, panel)] })
}
