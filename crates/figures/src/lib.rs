//! Figures of runs and of estimations, as SVG, PNG and PDF.
//!
//! Functions borrow the columns of a [`RunView`] or an [`EstimationView`] and return a [`Figure`]: a description, which
//! [`draw::file`] draws at any width and in any format. Pages and the Python package draw it themselves. Non-finite
//! samples leave gaps. Long records are reduced to the minimum and maximum of short intervals.
mod absolute;
mod cases;
mod characteristic;
mod comparison;
mod decision;
mod delays;
mod diagrams;
mod energy;
mod estimation;
mod events;
mod heat;
mod limits;
mod locus;
mod loop_response;
mod measured_loop;
mod overlay;
mod paper;
mod parameters;
mod pareto;
mod ports;
mod residual;
mod sketch;
mod stability;
mod strategies;
mod switching;
mod timeline;
mod tornado;
mod z_width;

pub use absolute::{AbsoluteView, absolute};
pub use cases::{CasesView, cases};
pub use characteristic::{CharacteristicView, characteristic};
pub use comparison::comparison;
pub use decision::decision;
pub use delays::delay_histogram;
pub use diagrams::{augmented_controller, insertion_phases, principle};
pub use energy::{EnergyView, energy};
pub use estimation::estimation;
pub use events::modes;
pub use heat::{AxisView, HeatView, heat_map};
pub use locus::locus;
pub use loop_response::loop_response;
pub use measured_loop::measured_loop;
pub use overlay::overlay;
pub use overlay::signals;
pub use paper::{distance, force, parameters_with_terms};
pub use parameters::STANDARD_ERRORS;
pub use parameters::parameters;
pub use pareto::{DesignView, Interval, ParetoView, ShippedView, pareto};
pub use ports::ports;
pub use residual::{distribution, residual_histogram};
pub use sketch::sketch;
pub use stability::{MapAxisView, MapView, stability_map};
pub use strategies::{StrategyView, strategies};
pub use switching::switching;
pub use timeline::{MAX_ROWS, TimelineRow, timeline};
pub use tornado::{InfluenceBar, tornado};
pub use z_width::z_width;

use std::borrow::Cow;
use std::ops::Range;

use limits::{Signal, shared};
use trocar_document::figure::{Axis, Figure, Shade, extent};

/// All columns have the same length.
#[derive(Clone, Debug)]
pub struct RunView<'a> {
    pub name: &'a str,
    pub is_augmented: bool,
    /// Increasing.
    pub time_s: &'a [f64],
    pub master_position_m: &'a [f64],
    pub slave_position_m: &'a [f64],
    /// Of the operator on the master, positive in the direction of insertion.
    pub operator_force_n: &'a [f64],
    /// On the needle, positive if it resists insertion.
    pub tissue_force_n: &'a [f64],
    /// Positive if it resists insertion.
    pub feedback_force_n: &'a [f64],
    /// 0 teleoperation, 1 event, 2 re-engaging.
    pub mode: &'a [u8],
    /// The shade of an event, depending on what restrains the slave.
    pub event: Shade,
    pub rupture_times_s: Cow<'a, [f64]>,
    pub alarm_times_s: Cow<'a, [f64]>,
}

/// All columns have the same length.
#[derive(Clone, Debug)]
pub struct EstimationView<'a> {
    pub name: &'a str,
    /// Increasing.
    pub time_s: &'a [f64],
    pub measured_force_n: &'a [f64],
    /// Measured minus estimated force.
    pub residual_n: &'a [f64],
    pub stiffness_n_per_m: &'a [f64],
    pub damping_n_s_per_m: &'a [f64],
    /// Standard errors of stiffness in N/m and damping in N·s/m, if known.
    pub standard_errors: Option<[Cow<'a, [f64]>; 2]>,
    pub extra_parameter: Option<(&'static str, &'a [f64])>,
    /// In `decision_unit`.
    pub decision: &'a [f64],
    /// γ, in `decision_unit`.
    pub threshold: f64,
    /// For example `N²`; `1` without a unit.
    pub decision_unit: &'a str,
    pub rupture_times_s: Cow<'a, [f64]>,
    pub alarm_times_s: Cow<'a, [f64]>,
}

pub type DrawEstimation = for<'a> fn(&EstimationView<'a>) -> Result<Figure<'a>, FigureError>;

pub const ESTIMATION_FIGURES: [(&str, DrawEstimation); 4] = [
    ("estimation", estimation),
    ("parameters", parameters),
    ("decision", decision),
    ("residual", |view| residual_histogram(view)),
];

pub type DrawRuns = for<'a> fn(&[RunView<'a>], Option<(f64, f64)>) -> Result<Figure<'a>, FigureError>;

pub const RUN_FIGURES: [(&str, DrawRuns); 2] = [("comparison", comparison), ("overlay", overlay)];

#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FigureError {
    #[error("the {figure} figure needs at least one run with at least one sample")]
    Empty { figure: &'static str },
    #[error("{name}: column {column} has {found} samples, but time_s has {expected}")]
    Length { name: String, column: &'static str, expected: usize, found: usize },
}

fn part<'a, T>(column: &'a [T], ticks: &Range<usize>) -> &'a [T] {
    let end = ticks.end.min(column.len());
    &column[ticks.start.min(end)..end]
}

fn part_of<'a>(column: Cow<'a, [f64]>, ticks: &Range<usize>) -> Cow<'a, [f64]> {
    match column {
        Cow::Borrowed(column) => part(column, ticks).into(),
        Cow::Owned(column) => part(&column, ticks).to_vec().into(),
    }
}

impl<'a> RunView<'a> {
    pub fn at(self, ticks: &Range<usize>) -> Self {
        Self {
            time_s: part(self.time_s, ticks),
            master_position_m: part(self.master_position_m, ticks),
            slave_position_m: part(self.slave_position_m, ticks),
            operator_force_n: part(self.operator_force_n, ticks),
            tissue_force_n: part(self.tissue_force_n, ticks),
            feedback_force_n: part(self.feedback_force_n, ticks),
            mode: part(self.mode, ticks),
            ..self
        }
    }

    fn check(&self, figure: &'static str) -> Result<(), FigureError> {
        let columns = [
            ("master_position_m", self.master_position_m.len()),
            ("slave_position_m", self.slave_position_m.len()),
            ("operator_force_n", self.operator_force_n.len()),
            ("tissue_force_n", self.tissue_force_n.len()),
            ("feedback_force_n", self.feedback_force_n.len()),
            ("mode", self.mode.len()),
        ];
        check(figure, self.name, self.time_s.len(), &columns)
    }
}

impl<'a> EstimationView<'a> {
    pub fn at(self, ticks: &Range<usize>) -> Self {
        Self {
            time_s: part(self.time_s, ticks),
            measured_force_n: part(self.measured_force_n, ticks),
            residual_n: part(self.residual_n, ticks),
            stiffness_n_per_m: part(self.stiffness_n_per_m, ticks),
            damping_n_s_per_m: part(self.damping_n_s_per_m, ticks),
            standard_errors: self.standard_errors.map(|errors| errors.map(|column| part_of(column, ticks))),
            extra_parameter: self.extra_parameter.map(|(name, column)| (name, part(column, ticks))),
            decision: part(self.decision, ticks),
            ..self
        }
    }

    fn check(&self, figure: &'static str) -> Result<(), FigureError> {
        let columns = [
            ("measured_force_n", self.measured_force_n.len()),
            ("residual_n", self.residual_n.len()),
            ("stiffness_n_per_m", self.stiffness_n_per_m.len()),
            ("damping_n_s_per_m", self.damping_n_s_per_m.len()),
            ("decision", self.decision.len()),
            self.extra_parameter.map_or(("extra_parameter", self.time_s.len()), |(name, column)| (name, column.len())),
        ];
        check(figure, self.name, self.time_s.len(), &columns)
    }

    fn time_axis(&self, max_ticks: usize) -> (Axis, (f64, f64)) {
        let axis = Axis::exact(extent(self.time_s.iter().copied()).unwrap_or((0.0, 1.0)), max_ticks);
        let range = (axis.low, axis.high);
        (axis, range)
    }

    fn force_axis(&self) -> Axis {
        shared(&[Signal::force(self.time_s, self.measured_force_n)], (f64::NEG_INFINITY, f64::INFINITY))
    }
}

fn check_runs(figure: &'static str, runs: &[RunView<'_>]) -> Result<(), FigureError> {
    if runs.is_empty() {
        return Err(FigureError::Empty { figure });
    }
    runs.iter().try_for_each(|run| run.check(figure))
}

fn check(
    figure: &'static str,
    name: &str,
    expected: usize,
    columns: &[(&'static str, usize)],
) -> Result<(), FigureError> {
    if expected == 0 {
        return Err(FigureError::Empty { figure });
    }
    match columns.iter().find(|column| column.1 != expected) {
        Some(&(column, found)) => Err(FigureError::Length { name: name.to_owned(), column, expected, found }),
        None => Ok(()),
    }
}

#[cfg(test)]
fn shown(figure: &Figure<'_>) -> String {
    figure.description().to_string()
}
