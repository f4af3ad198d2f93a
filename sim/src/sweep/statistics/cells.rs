//! Metrics over two axes: the mean in each cell of a grid.

use serde::Serialize;

use crate::moments::Moments;
use crate::sweep::axis::{Axis, number};
use crate::sweep::design::Design;

/// Classes of an axis that has no levels, or more.
const MAX_CLASSES: u64 = 40;

/// One cell.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Cell {
    /// The value of the first axis at its middle.
    pub x: f64,
    /// That of the second.
    pub y: f64,
    /// In how many of its cases the metric is defined.
    pub defined: u64,
    /// The metric's mean over them; none where there are none.
    pub mean: Option<f64>,
    /// Half the width of the mean's 95 % interval.
    pub mean_ci95_half_width: Option<f64>,
}

/// A metric over two axes.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct HeatMap {
    /// Which metric, as a place among the columns.
    pub column: usize,
    /// Which axis goes to the right.
    pub x_axis: usize,
    /// Which goes up.
    pub y_axis: usize,
    /// How many cells there are to the right.
    pub x_count: usize,
    /// The cells, row by row, both axes ascending.
    pub cells: Vec<Cell>,
}

/// How many classes an axis falls into.
pub(super) fn classes(axis: &Axis, most: u64) -> u64 {
    axis.count().filter(|count| *count <= most).unwrap_or(most)
}

/// The class of a share.
pub(super) fn class(share: f64, classes: u64) -> usize {
    (share * classes as f64) as usize
}

/// The cells of all metrics in focus, while they are filled.
pub(super) struct Cells<'a> {
    design: &'a Design,
    /// The axes and how many classes each has.
    axes: Option<[(usize, u64); 2]>,
    /// By metric in focus, second axis and first axis.
    moments: Vec<Moments>,
}

impl<'a> Cells<'a> {
    pub(super) fn new(design: &'a Design) -> Self {
        let varied = |(_, axis): &(usize, &Axis)| axis.is_numeric() && axis.count() != Some(1);
        let mut numeric = design.axes.iter().enumerate().filter(varied);
        let axes = numeric.next().zip(numeric.next());
        let axes = axes.map(|(x, y)| [x, y].map(|(index, axis)| (index, classes(axis, MAX_CLASSES))));
        let cells = axes.map_or(0, |[(_, x), (_, y)]| (x * y) as usize);
        Self { design, axes, moments: vec![Moments::default(); cells * design.focus.len()] }
    }

    pub(super) fn add(&mut self, shares: &[f64], values: &[f64]) {
        let Some([(x, x_count), (y, y_count)]) = self.axes else { return };
        let cell = class(shares[y], y_count) * x_count as usize + class(shares[x], x_count);
        let cells = (x_count * y_count) as usize;
        for (place, column) in self.design.focus.iter().enumerate() {
            self.moments[place * cells + cell].add_defined(values[*column]);
        }
    }

    pub(super) fn heat_maps(&self) -> Vec<HeatMap> {
        let Some([(x, x_count), (y, y_count)]) = self.axes else { return vec![] };
        let (x_middles, y_middles) = (self.middles(x, x_count), self.middles(y, y_count));
        let cells = (x_count * y_count) as usize;
        let of_focus = |(place, column): (usize, &usize)| {
            let mut map = HeatMap { column: *column, x_axis: x, y_axis: y, x_count: x_count as usize, cells: vec![] };
            for (j, y) in &y_middles {
                for (i, x) in &x_middles {
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

    /// The classes of an axis with the values in their middles, ascending.
    fn middles(&self, axis: usize, classes: u64) -> Vec<(usize, f64)> {
        let middle = |class: u64| {
            let value = self.design.axes[axis].value((class as f64 + 0.5) / classes as f64);
            (class as usize, number(&value).unwrap_or(f64::NAN))
        };
        let mut middles: Vec<_> = (0..classes).map(middle).collect();
        middles.sort_by(|a, b| a.1.total_cmp(&b.1));
        middles
    }
}
