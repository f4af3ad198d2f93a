//! The Z-width: the maximum stiffness of stable and passive walls over their damping.

use super::FigureError;
use super::axis::{Axis, X_TICKS, extent};
use super::figure::{Figure, Row};
use super::legend::Sample;
use super::panel::{Panel, Trace};
use super::style::{GREEN, SKY, Stroke};

/// The maximum stiffness of walls in N/m, for each damping; `None` or infinite where there is none to draw.
#[derive(Clone, Debug)]
pub struct WallsView {
    /// Stable walls.
    pub stable: Vec<Option<f64>>,
    /// Passive walls.
    pub passive: Vec<Option<f64>>,
}

/// The Z-width.
#[derive(Clone, Debug)]
pub struct ZWidthView {
    /// Name of the scenario.
    pub name: String,
    /// Damping of the walls in N·s/m, increasing.
    pub damping_n_s_per_m: Vec<f64>,
    /// Walls in the tissue.
    pub tissue: WallsView,
    /// Virtual walls.
    pub virtual_walls: Option<WallsView>,
}

/// Draws the Z-width.
///
/// # Errors
/// [`FigureError::Empty`] without dampings, [`FigureError::Length`] for columns of unequal lengths.
pub fn z_width(view: &ZWidthView) -> Result<Figure<'static>, FigureError> {
    let Some((low, high)) = extent(view.damping_n_s_per_m.iter().copied()) else {
        return Err(FigureError::Empty { figure: "z_width" });
    };
    let [tissue, virtual_wall] = [SKY, GREEN].map(|color| Stroke::solid(color, 1.2));
    let dashed = |stroke: Stroke| Stroke { dashes: &[5.0, 3.0], ..stroke };
    let mut lines = vec![
        ("stable walls in the tissue", &view.tissue.stable, tissue),
        ("passive walls in the tissue", &view.tissue.passive, dashed(tissue)),
    ];
    if let Some(walls) = &view.virtual_walls {
        lines.push(("stable walls computed by the master", &walls.stable, virtual_wall));
        lines.push(("passive walls computed by the master", &walls.passive, dashed(virtual_wall)));
    }
    for (name, values, _) in &lines {
        super::check("z_width", "walls", view.damping_n_s_per_m.len(), &[(*name, values.len())])?;
    }
    let is_drawn = |value: &f64| *value > 0.0 && value.is_finite();
    let points: Vec<(Vec<f64>, Vec<f64>)> = lines
        .iter()
        .map(|(_, values, _)| {
            let each = view.damping_n_s_per_m.iter().zip(values.iter());
            each.filter_map(|(damping, value)| Some((*damping, value.filter(is_drawn)?))).unzip()
        })
        .collect();
    let (min, max) = extent(points.iter().flat_map(|(_, y)| y.iter().copied())).unwrap_or((1.0, 10.0));
    let traces = points.into_iter().zip(&lines).filter(|((x, _), _)| !x.is_empty());
    let panel = Panel {
        traces: traces.map(|((x, y), (_, _, stroke))| Trace::new(x, y, *stroke)).collect(),
        ..Panel::new(
            Axis::exact((low, high), X_TICKS),
            "Damping of the wall (N·s/m)",
            Axis::log10((min / 1.5, 1.5 * max)),
            "Maximum stiffness of the wall (N/m)",
        )
    };
    let legend = lines.iter().map(|(name, _, stroke)| (Sample::Line(*stroke), (*name).to_owned())).collect();
    Ok(Figure { name: view.name.clone(), legend, rows: vec![Row::of(195.0, panel)] })
}
