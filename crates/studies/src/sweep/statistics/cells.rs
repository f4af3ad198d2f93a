use serde::Serialize;

use crate::sweep::axis::{Axis, number};
use crate::sweep::design::{Design, SamplingScheme};
use trocar_base::moments::Moments;

/// Number for an axis without levels, otherwise a maximum.
const MAX_CLASSES: u64 = 40;

#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Cell {
    pub x: f64,
    pub y: f64,
    pub defined: u64,
    pub mean: Option<f64>,
    pub mean_ci95_half_width: Option<f64>,
}

/// Means of a metric over two axes.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct HeatMap {
    pub column: usize,
    pub x_axis: usize,
    pub y_axis: usize,
    pub x_count: usize,
    /// Rows with both axes ascending.
    pub cells: Vec<Cell>,
}

pub(super) fn classes(axis: &Axis, max: u64) -> u64 {
    axis.count().filter(|count| *count <= max).unwrap_or(max)
}

pub(super) fn class(coordinate: f64, classes: u64) -> usize {
    (coordinate * classes as f64) as usize
}

pub(super) struct Cells<'a> {
    design: &'a Design,
    axes: Option<[(usize, u64); 2]>,
    /// Ordered by metric in focus, second axis, first axis.
    moments: Vec<Moments>,
}

impl<'a> Cells<'a> {
    pub(super) fn new(design: &'a Design) -> Self {
        // Given points fill no map.
        let is_filled = !matches!(design.scheme, SamplingScheme::List { .. });
        let varied = |(_, axis): &(usize, &Axis)| is_filled && axis.is_numeric() && axis.count() != Some(1);
        let mut numeric = design.axes.iter().enumerate().filter(varied);
        let axes = numeric.next().zip(numeric.next());
        let axes = axes.map(|(x, y)| [x, y].map(|(index, axis)| (index, classes(axis, MAX_CLASSES))));
        let cells = axes.map_or(0, |[(_, x), (_, y)]| (x * y) as usize);
        Self { design, axes, moments: vec![Moments::default(); cells * design.focus.len()] }
    }

    pub(super) fn add(&mut self, coordinates: &[f64], values: &[f64]) {
        let Some([(x, x_count), (y, y_count)]) = self.axes else { return };
        let cell = class(coordinates[y], y_count) * x_count as usize + class(coordinates[x], x_count);
        let cells = (x_count * y_count) as usize;
        for (place, column) in self.design.focus.iter().enumerate() {
            self.moments[place * cells + cell].add_finite(values[*column]);
        }
    }

    pub(super) fn heat_maps(&self) -> Vec<HeatMap> {
        let Some([(x, x_count), (y, y_count)]) = self.axes else { return vec![] };
        let (x_centres, y_centres) = (self.centres(x, x_count), self.centres(y, y_count));
        let cells = (x_count * y_count) as usize;
        let of_focus = |(place, column): (usize, &usize)| {
            let mut map = HeatMap { column: *column, x_axis: x, y_axis: y, x_count: x_count as usize, cells: vec![] };
            for (j, y) in &y_centres {
                for (i, x) in &x_centres {
                    let moments = &self.moments[place * cells + j * x_count as usize + i];
                    let is_any = moments.count > 0;
                    map.cells.push(Cell {
                        x: *x,
                        y: *y,
                        defined: moments.count,
                        mean: is_any.then_some(moments.mean),
                        mean_ci95_half_width: is_any.then(|| 1.96 * moments.standard_error()),
                    });
                }
            }
            map
        };
        self.design.focus.iter().enumerate().map(of_focus).collect()
    }

    fn centres(&self, axis: usize, classes: u64) -> Vec<(usize, f64)> {
        let centre = |class: u64| {
            let value = self.design.axes[axis].value((class as f64 + 0.5) / classes as f64);
            (class as usize, number(&value).unwrap_or(f64::NAN))
        };
        let mut centres: Vec<_> = (0..classes).map(centre).collect();
        centres.sort_by(|a, b| a.1.total_cmp(&b.1));
        centres
    }
}
