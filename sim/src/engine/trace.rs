//! Recording every tick.

use super::{Observer, Signals};
use crate::time::TickGrid;

/// The columns of a trace, in the order of its file.
pub const COLUMNS: [&str; 17] = [
    "time_s",
    "desired_position_m",
    "master_position_m",
    "master_velocity_m_per_s",
    "operator_force_n",
    "slave_reference_m",
    "slave_position_m",
    "slave_velocity_m_per_s",
    "tissue_force_n",
    "measured_force_n",
    "feedback_force_n",
    "stiffness_n_per_m",
    "damping_n_s_per_m",
    "residual_n",
    "distance",
    "decision",
    "mode",
];

/// One run's signals, a vector per column, equal lengths, in the units of their names.
#[derive(Debug, Clone, PartialEq)]
#[allow(missing_docs, reason = "the names and units are those of COLUMNS, documented with Signals")]
pub struct Trace {
    pub time_s: Vec<f64>,
    pub desired_position_m: Vec<f64>,
    pub master_position_m: Vec<f64>,
    pub master_velocity_m_per_s: Vec<f64>,
    pub operator_force_n: Vec<f64>,
    pub slave_reference_m: Vec<f64>,
    pub slave_position_m: Vec<f64>,
    pub slave_velocity_m_per_s: Vec<f64>,
    pub tissue_force_n: Vec<f64>,
    pub measured_force_n: Vec<f64>,
    pub feedback_force_n: Vec<f64>,
    pub stiffness_n_per_m: Vec<f64>,
    pub damping_n_s_per_m: Vec<f64>,
    pub residual_n: Vec<f64>,
    pub distance: Vec<f64>,
    pub decision: Vec<f64>,
    pub mode: Vec<u8>,
    /// What the estimator estimates besides: the column's name, and its values.
    pub extra_parameter: Option<(&'static str, Vec<f64>)>,
    grid: TickGrid,
}

impl Trace {
    /// An empty trace with room for every tick of the grid.
    #[must_use]
    pub fn new(grid: TickGrid) -> Self {
        let room = || Vec::with_capacity(grid.ticks() as usize);
        Self {
            time_s: room(),
            desired_position_m: room(),
            master_position_m: room(),
            master_velocity_m_per_s: room(),
            operator_force_n: room(),
            slave_reference_m: room(),
            slave_position_m: room(),
            slave_velocity_m_per_s: room(),
            tissue_force_n: room(),
            measured_force_n: room(),
            feedback_force_n: room(),
            stiffness_n_per_m: room(),
            damping_n_s_per_m: room(),
            residual_n: room(),
            distance: room(),
            decision: room(),
            mode: Vec::with_capacity(grid.ticks() as usize),
            extra_parameter: None,
            grid,
        }
    }

    /// The same trace with one more column, of a name, for what the estimator estimates besides.
    #[must_use]
    pub fn with_extra_parameter(mut self, column: Option<&'static str>) -> Self {
        self.extra_parameter = column.map(|name| (name, Vec::with_capacity(self.grid.ticks() as usize)));
        self
    }

    /// How many ticks it holds.
    #[must_use]
    pub fn len(&self) -> usize {
        self.time_s.len()
    }

    /// Whether it holds none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.time_s.is_empty()
    }

    /// The columns before `mode`, in the order of [`COLUMNS`].
    #[must_use]
    pub fn numbers(&self) -> [&[f64]; 16] {
        [
            &self.time_s,
            &self.desired_position_m,
            &self.master_position_m,
            &self.master_velocity_m_per_s,
            &self.operator_force_n,
            &self.slave_reference_m,
            &self.slave_position_m,
            &self.slave_velocity_m_per_s,
            &self.tissue_force_n,
            &self.measured_force_n,
            &self.feedback_force_n,
            &self.stiffness_n_per_m,
            &self.damping_n_s_per_m,
            &self.residual_n,
            &self.distance,
            &self.decision,
        ]
    }
}

impl Observer<f64> for Trace {
    fn observe(&mut self, s: &Signals<f64>) {
        self.time_s.push(self.grid.time_s(s.tick));
        self.desired_position_m.push(s.desired_position_m);
        self.master_position_m.push(s.master_position_m);
        self.master_velocity_m_per_s.push(s.master_velocity_m_per_s);
        self.operator_force_n.push(s.operator_force_n);
        self.slave_reference_m.push(s.slave_reference_m);
        self.slave_position_m.push(s.slave_position_m);
        self.slave_velocity_m_per_s.push(s.slave_velocity_m_per_s);
        self.tissue_force_n.push(s.tissue_force_n);
        self.measured_force_n.push(s.measured_force_n);
        self.feedback_force_n.push(s.feedback_force_n);
        self.stiffness_n_per_m.push(s.stiffness_n_per_m);
        self.damping_n_s_per_m.push(s.damping_n_s_per_m);
        self.residual_n.push(s.residual_n);
        self.distance.push(s.distance);
        self.decision.push(s.decision);
        self.mode.push(s.mode as u8);
        if let Some((_, further)) = &mut self.extra_parameter {
            further.push(s.extra_parameter);
        }
    }
}
