//! Maps over two parameters: a value or a verdict for each cell, drawn by `assets/report.js`.

use serde::Serialize;

use crate::digits::{Few, Fine};
use crate::number::readable;
use trocar_sim::stability::{Analysis, Axis, Spacing, StabilityMap};
use trocar_sim::stability_check::Check;
use trocar_sim::sweep::{Design, HeatMap};

/// Maximum number of cells along each axis. Of more cells, an even selection is drawn.
const MAX_CELLS: usize = 400;

/// Maximum number of segments of a boundary. Of more segments, an even selection is drawn.
const MAX_PIECES: usize = 8_000;

/// Maximum number of drawn points at which the simulation disagrees.
const MAX_POINTS: usize = 500;

/// An axis of a map. Values are the centres of the cells, ascending.
#[derive(Clone, Debug, Serialize)]
pub(super) struct MapAxis {
    label: String,
    log: bool,
    values: Vec<Fine>,
}

/// A map.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Map {
    title: String,
    alt: String,
    /// Unit of the values.
    unit: &'static str,
    x: MapAxis,
    y: MapAxis,
    /// A value per cell, row by row from below.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    cells: Vec<Few>,
    /// Or a verdict per cell: one text per row, `1` for stable.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    verdicts: Vec<String>,
    boundary: Vec<[Few; 4]>,
    /// The values of the scenario.
    here: Option<[Fine; 2]>,
    /// Points at which a simulated run disagrees.
    differing: Vec<[Few; 2]>,
}

/// Returns the step with which at most `max` of `count` items are selected.
fn stride(count: usize, max: usize) -> usize {
    count.div_ceil(max).max(1)
}

impl Map {
    /// Returns the stability map, and whether some of its points are omitted.
    pub(super) fn of_stability(analysis: &Analysis, map: &StabilityMap, check: Option<&Check>) -> (Self, bool) {
        let (every_column, every_row) = (stride(map.x.count, MAX_CELLS), stride(map.y.count, MAX_CELLS));
        let axis = |axis: &Axis, every: usize| MapAxis {
            label: axis.parameter.caption().to_owned(),
            log: axis.spacing == Spacing::Logarithmic,
            values: (0..axis.count).step_by(every).map(|index| Fine(axis.value(index))).collect(),
        };
        let word = |row| {
            let verdict = |column| if map.is_stable(column, row) { '1' } else { '0' };
            (0..map.x.count).step_by(every_column).map(verdict).collect()
        };
        let pieces = map.boundary.iter().step_by(stride(map.boundary.len(), MAX_PIECES));
        let differing = check.map_or(vec![], |check| {
            check.disagreements.iter().take(MAX_POINTS).map(|d| [Few(d.x), Few(d.y)]).collect()
        });
        let here = [map.x.parameter, map.y.parameter].map(|parameter| Fine(analysis.settings.get(parameter)));
        let title = format!("{} by {}", map.x.parameter.caption(), map.y.parameter.caption());
        let drawn = Self {
            alt: format!(
                "Map of {title}: {:.1} % of {} by {} points are stable; the scenario is at {} and {}.",
                100.0 * map.stable_share(),
                map.x.count,
                map.y.count,
                crate::number::significant(here[0].0),
                crate::number::significant(here[1].0),
            ),
            title,
            unit: "",
            x: axis(&map.x, every_column),
            y: axis(&map.y, every_row),
            cells: vec![],
            verdicts: (0..map.y.count).step_by(every_row).map(word).collect(),
            boundary: pieces.map(|[a, b]| [a.0, a.1, b.0, b.1].map(Few)).collect(),
            here: Some(here),
            differing,
        };
        (drawn, every_column > 1 || every_row > 1)
    }

    /// Returns the mean of a metric over the first two axes of a sweep.
    pub(super) fn of_sweep(design: &Design, map: &HeatMap) -> Self {
        let column = &design.columns[map.column];
        let (factor, unit) = readable(column.unit);
        let axis = |index: usize, values: Vec<Fine>| {
            let axis = &design.axes[index];
            MapAxis { label: axis.key.path.to_owned(), log: axis.is_log(), values }
        };
        let x = map.cells.iter().take(map.x_count).map(|cell| Fine(cell.x)).collect();
        let y = map.cells.iter().step_by(map.x_count.max(1)).map(|cell| Fine(cell.y)).collect();
        let cells: Vec<f64> = map.cells.iter().map(|cell| factor * cell.mean.unwrap_or(f64::NAN)).collect();
        let defined = cells.iter().copied().filter(|value| value.is_finite());
        let (min, max) = defined.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, m), v| (l.min(v), m.max(v)));
        let [x_name, y_name] = [map.x_axis, map.y_axis].map(|index| design.axes[index].key.path);
        let shown = crate::number::significant;
        let span = if min <= max { format!("from {} to {}{unit}", shown(min), shown(max)) } else { "undefined".into() };
        Self {
            title: format!("{}, mean", column.name),
            alt: format!("Map of the mean of {} over {x_name} and {y_name}: {span}.", column.name),
            unit: unit.trim_start(),
            x: axis(map.x_axis, x),
            y: axis(map.y_axis, y),
            cells: cells.into_iter().map(Few).collect(),
            verdicts: vec![],
            boundary: vec![],
            here: None,
            differing: vec![],
        }
    }
}
