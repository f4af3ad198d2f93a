//! The numbers of a run.

use serde::Serialize;

use super::{EventMetrics, RuptureMetrics};
use crate::teleoperation::LinkReport;
use crate::time::TickGrid;

/// How a run ended. Diverging is a result, not an error.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(tag = "kind", rename_all = "kebab-case")]
pub enum Outcome {
    /// Every tick was run.
    Completed,
    /// A position left the bounds of the sensible; the run was ended there.
    Diverged {
        /// When, in s.
        time_s: f64,
    },
}

/// An alarm that was taken.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Alarm {
    /// When, in s.
    pub time_s: f64,
    /// Whether it announced a rupture, the first to do so.
    pub matched: bool,
}

/// Time spent in each mode, in s.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ModeTimes {
    /// Following the hand.
    pub teleoperation_s: f64,
    /// Frozen.
    pub augmented_s: f64,
    /// Finding back.
    pub reengaging_s: f64,
}

/// What the link between the sides has seen and done.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct LinkMetrics {
    /// Outages of either direction.
    pub outages: u64,
    /// The longest, in s.
    pub longest_outage_s: f64,
    /// When the slave gave the link up, in s.
    pub given_up_s: Option<f64>,
    /// `∫ F_ed dx_h` in J: what the master put into the link.
    pub master_port_energy_j: f64,
    /// `∫ f_e dx_e` in J with the measured force: what the needle put into the tissue.
    pub slave_port_energy_j: f64,
    /// What passivity dissipated at the master, in J.
    pub master_dissipated_j: f64,
    /// What it kept from the slave, in J.
    pub slave_refused_j: f64,
}

impl LinkMetrics {
    /// The metrics of a link that ran on a grid.
    #[must_use]
    pub fn new(report: &LinkReport, grid: &TickGrid) -> Self {
        let seconds = |ticks: f64| grid.time_s(ticks as u64);
        Self {
            outages: report.outages,
            longest_outage_s: seconds(report.longest_outage_ticks),
            given_up_s: report.given_up_tick.map(seconds),
            master_port_energy_j: report.master_port_j,
            slave_port_energy_j: report.slave_port_j,
            master_dissipated_j: report.master_dissipated_j,
            slave_refused_j: report.slave_refused_j,
        }
    }
}

/// Every metric of one run.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Metrics {
    /// How it ended.
    pub outcome: Outcome,
    /// How many ticks were run.
    pub ticks: u64,
    /// One entry per rupture, in time order.
    pub ruptures: Vec<RuptureMetrics>,
    /// One entry per augmented event, in time order.
    pub events: Vec<EventMetrics>,
    /// The alarms that were taken, in time order (the first 4096).
    pub alarms: Vec<Alarm>,
    /// Ruptures that no alarm announced which was taken.
    pub missed_ruptures: u64,
    /// Ruptures without an alarm whose window the run did not see to its end.
    pub undecided_ruptures: u64,
    /// Alarms taken that announced none, or one that had been announced.
    pub false_alarms: u64,
    /// Alarms not taken, as an event was under way or had just ended.
    pub ignored_alarms: u64,
    /// Mean of `|e|` in N.
    pub mean_absolute_residual_n: Option<f64>,
    /// Smallest tissue force in N, resisting insertion positive.
    pub least_tissue_force_n: Option<f64>,
    /// Largest tissue force in N.
    pub greatest_tissue_force_n: Option<f64>,
    /// Root mean square of `x_e - x_ref` in teleoperation, in m.
    pub tracking_rmse_m: Option<f64>,
    /// The slave's position at the last tick, in m.
    pub final_slave_position_m: Option<f64>,
    /// `(x_ref - x_e) / x_ref` at the last tick, the static error where the reference is constant.
    pub final_tracking_error: Option<f64>,
    /// Greatest speed of the slave while re-engaging, in m/s.
    pub peak_reengaging_speed_m_per_s: Option<f64>,
    /// By how much a change of the fed-back force during an event exceeded what its law allows, in N: 0 but for
    /// rounding.
    pub feedback_step_excess_n: f64,
    /// Time per mode.
    pub mode_times: ModeTimes,
    /// Changes of mode.
    pub mode_switches: u64,
    /// `∫ F_h v_h dt` in J: what the hand put into the master.
    pub operator_energy_j: Option<f64>,
    /// `∫ f_e v_e dt` in J: what the slave put into the tissue.
    pub tissue_energy_j: Option<f64>,
    /// What the link has seen; none where positions and forces arrive at once and as they are.
    pub link: Option<LinkMetrics>,
}
