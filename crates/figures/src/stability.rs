use super::FigureError;
use trocar_document::figure::{
    Axis, BLACK, Color, Figure, GREY, ORANGE, PURPLE, Panel, Point, Row, Sample, Stroke, WHITE, X_TICKS, Y_TICKS,
};

const STABLE: Color = GREY.pale(0.2);
const BOUNDARY: Stroke = Stroke::solid(PURPLE, 1.3);
/// A run whose motion decays, and a run whose motion grows.
const DECAYS: Stroke = Stroke::solid(GREY, 1.2);
const GROWS: Stroke = Stroke::solid(PURPLE, 1.8);
const DIFFERS: Stroke = Stroke::solid(ORANGE, 3.2);
const SCENARIO: Stroke = Stroke::solid(BLACK, 5.0);

/// Distance of the scenario's text from its point, and from the left and right edges, as shares of the axes.
const NOTE_RISE: f64 = 0.06;
const NOTE_MARGIN: f64 = 0.1;

const RUNS_PER_AXIS: usize = 28;

#[derive(Clone, Copy, Debug)]
pub struct MapAxisView<'a> {
    pub caption: &'a str,
    /// The values, increasing.
    pub values: &'a [f64],
    /// True if the axis is logarithmic. Every value is then above 0.
    pub is_logarithmic: bool,
    pub scenario_value: f64,
}

#[derive(Clone, Debug)]
pub struct MapView<'a> {
    pub name: &'a str,
    pub x: MapAxisView<'a>,
    pub y: MapAxisView<'a>,
    /// Row by row.
    pub stable: &'a [bool],
    pub boundary: &'a [[(f64, f64); 2]],
    /// The simulated motion grew: row by row; `None` at a point without a run.
    pub grew: &'a [Option<bool>],
}

/// Draws the map: the stable region is shaded, the boundary is a line, and runs are dots; larger and orange if they
/// disagree with the analysis. A scenario outside the map has its dot on the edge, and the legend says so.
pub fn stability_map(view: &MapView<'_>) -> Result<Figure<'static>, FigureError> {
    let MapView { x, y, .. } = view;
    let (columns, rows) = (x.values.len(), y.values.len());
    if columns < 2 || rows < 2 || view.stable.len() != columns * rows {
        return Err(FigureError::Empty { figure: "stability map" });
    }
    let (x_axis, y_axis) = (axis(x, X_TICKS), axis(y, Y_TICKS));
    let (x_edges, y_edges) = (edges(x, &x_axis), edges(y, &y_axis));
    let mut panel = Panel::new(x_axis.clone(), x.caption, y_axis.clone(), y.caption);
    for row in 0..rows {
        let verdicts = &view.stable[row * columns..(row + 1) * columns];
        let mut column = 0;
        while column < columns {
            let length = verdicts[column..].iter().take_while(|stable| **stable == verdicts[column]).count();
            if verdicts[column] {
                let (left, right) = (x_edges[column], x_edges[column + length]);
                let (low, high) = (y_edges[row], y_edges[row + 1]);
                panel.fills.push((vec![(left, low), (right, low), (right, high), (left, high)], STABLE));
            }
            column += length;
        }
    }
    panel.measurements = vec!["stable".to_owned(); panel.fills.len()];
    panel.measurements.push("not stable".to_owned());
    let place = |point: Point| (x_axis.place(point.0), y_axis.place(point.1));
    // One line with a gap after each segment.
    let pieces = view.boundary.iter().flat_map(|[from, to]| [place(*from), place(*to), (f64::NAN, f64::NAN)]);
    panel.curves.push((pieces.collect(), BOUNDARY));
    panel.curves.extend(dots(view).map(|(point, stroke)| (vec![place(point)], stroke)));
    let exact = place((x.scenario_value, y.scenario_value));
    let scenario = (x_axis.within(exact.0), y_axis.within(exact.1));
    let scenario_is = if scenario == exact { "this scenario" } else { "this scenario (beyond the edge of the map)" };
    panel.curves.push((vec![scenario], Stroke::solid(WHITE, 7.0)));
    panel.curves.push((vec![scenario], SCENARIO));
    panel.notes.push((beside(scenario, &x_axis, &y_axis), "this scenario".to_owned()));
    let mut legend = vec![
        (Sample::Shade(STABLE), "stable".to_owned()),
        (Sample::Line(BOUNDARY), "boundary (analysis)".to_owned()),
        (Sample::Dot(SCENARIO), scenario_is.to_owned()),
    ];
    if view.grew.iter().any(Option::is_some) {
        legend.push((Sample::Dot(DECAYS), "simulation: decays".to_owned()));
        legend.push((Sample::Dot(GROWS), "simulation: grows".to_owned()));
    }
    if view.grew.iter().zip(view.stable).any(|(grew, stable)| *grew == Some(*stable)) {
        legend.push((Sample::Dot(DIFFERS), "simulation: disagrees".to_owned()));
    }
    Ok(Figure { name: view.name.to_owned(), legend, rows: vec![Row::of(240.0, panel)] })
}

/// The position of a point's text: above it, or below near the upper edge, and within the axes.
fn beside((x, y): Point, x_axis: &Axis, y_axis: &Axis) -> Point {
    let (width, height) = (x_axis.high - x_axis.low, y_axis.high - y_axis.low);
    let above = y + NOTE_RISE * height;
    let is_inside = above < y_axis.high - 0.5 * NOTE_RISE * height;
    let middle = x.clamp(x_axis.low + NOTE_MARGIN * width, x_axis.high - NOTE_MARGIN * width);
    (middle, if is_inside { above } else { y - NOTE_RISE * height })
}

/// An even selection of the runs, and all that disagree with the analysis.
fn dots<'a>(view: &'a MapView<'_>) -> impl Iterator<Item = (Point, Stroke)> + 'a {
    let (columns, rows) = (view.x.values.len(), view.y.values.len());
    let (every_column, every_row) = (columns.div_ceil(RUNS_PER_AXIS), rows.div_ceil(RUNS_PER_AXIS));
    view.grew.iter().enumerate().filter_map(move |(index, grew)| {
        let grew = (*grew)?;
        let (row, column) = (index / columns, index % columns);
        let point = (view.x.values[column], view.y.values[row]);
        if grew == view.stable[index] {
            return Some((point, DIFFERS));
        }
        let is_shown = row % every_row == every_row / 2 && column % every_column == every_column / 2;
        is_shown.then_some((point, if grew { GROWS } else { DECAYS }))
    })
}

fn axis(view: &MapAxisView<'_>, ticks: usize) -> Axis {
    let range = (view.values[0], view.values[view.values.len() - 1]);
    Axis::over(range, view.is_logarithmic, ticks)
}

fn edges(view: &MapAxisView<'_>, axis: &Axis) -> Vec<f64> {
    let places: Vec<f64> = view.values.iter().map(|value| axis.place(*value)).collect();
    let inner = places.windows(2).map(|pair| 0.5 * (pair[0] + pair[1]));
    std::iter::once(axis.low).chain(inner).chain(std::iter::once(axis.high)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_stable_region_is_shaded_and_runs_are_dots() {
        let values = [1.0, 10.0, 100.0];
        let axis = |caption| MapAxisView { caption, values: &values, is_logarithmic: true, scenario_value: 1.0 };
        let stable = [true, true, true, true, false, false, true, false, false];
        let view = MapView {
            name: "classical",
            x: axis("Force scale"),
            y: axis("Tissue stiffness (N/m)"),
            stable: &stable,
            boundary: &[[(3.0, 10.0), (10.0, 3.0)]],
            grew: &[],
        };
        let shown = |view: &MapView<'_>| crate::shown(&stability_map(view).expect("a figure"));
        let plain = shown(&view);
        assert!(plain.contains("Tissue stiffness (N/m)") && !plain.contains("simulation"));
        assert!(plain.contains("\"this scenario\""));
        let softer = MapView { y: MapAxisView { scenario_value: 0.0, ..view.y }, ..view.clone() };
        let figure = stability_map(&softer).expect("a figure");
        let dot = &figure.rows[0].panels[0].curves.last().expect("the scenario").0;
        assert_eq!(*dot, [(0.0, 0.0)], "on the lower edge, at 1 N/m");
        let (note, _) = &figure.rows[0].panels[0].notes[0];
        assert!(note.0 > 0.1 && (0.05..0.3).contains(&note.1), "above the dot, within the axes: {note:?}");
        assert!(beside((1.0, 2.0), &Axis::log10((1.0, 100.0)), &Axis::log10((1.0, 100.0))).1 < 2.0);
        assert!(crate::shown(&figure).contains("this scenario (beyond the edge of the map)"));
        let grew: Vec<Option<bool>> = stable.iter().map(|stable| Some(!stable)).collect();
        let checked = shown(&MapView { grew: &grew, ..view.clone() });
        assert!(checked.contains("simulation: grows") && !checked.contains("simulation: disagrees"));
        let differs: Vec<Option<bool>> = stable.iter().map(|stable| Some(*stable)).collect();
        let disagreeing = shown(&MapView { grew: &differs, ..view.clone() });
        assert!(disagreeing.contains("simulation: disagrees"));
        assert!(matches!(stability_map(&MapView { stable: &[], ..view }), Err(FigureError::Empty { .. })));
    }
}
