use serde::Serialize;

use super::{EventMetrics, PortMetrics, RuptureMetrics};
use crate::metrics;
use trocar_core::time::TickGrid;
use trocar_engine::teleoperation::LinkReport;

/// How a run ended. Divergence is a result, not an error.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(tag = "kind", rename_all = "kebab-case")]
pub enum Outcome {
    /// Every tick was run.
    Completed,
    /// Every tick was run, and at the end the needle or the master oscillates without decaying. Reported only for runs
    /// with a trace.
    Oscillating {
        /// Frequency of the oscillation in Hz.
        frequency_hz: f64,
        /// Median distance from a peak to a trough, in m.
        swing_m: f64,
    },
    /// A position or force exceeded its bound and ended the run.
    Diverged {
        /// The time of the divergence in s.
        time_s: f64,
    },
}

/// An accepted alarm.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Alarm {
    /// The time of the alarm in s.
    pub time_s: f64,
    /// True if it is the first alarm of a rupture.
    pub matched: bool,
}

/// Time spent in each mode, in s.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ModeTimes {
    /// Time in teleoperation, when the slave follows the master.
    pub teleoperation_s: f64,
    /// Time in an event, up to the release of the slave.
    pub augmented_s: f64,
    /// Time of re-engaging.
    pub reengaging_s: f64,
}

metrics! {
    /// The metrics of the link between master and slave.
    #[derive(Debug, Clone, Copy, PartialEq, Serialize)]
    #[cfg_attr(feature = "schema", derive(schemars::JsonSchema), schemars(transform = crate::schema::with_units(Self::METRICS)))]
    pub struct LinkMetrics in Link {
        /// Number of outages of the link, in either direction.
        outages: u64 = "outages", Count, Neither [WhereNonZero];
        /// Duration of the longest outage.
        longest_outage_s: f64 = "longest outage", Second, Neither [WhereNonZero];
        /// Time at which the slave stopped following the link.
        given_up_s: Option<f64> = "given up at", Second, Neither [WhereNonZero];
        /// Work of the master on the link, ∫ F_ed dx_h.
        master_port_energy_j: f64 = "energy from the master", Joule, Neither [Never];
        /// Work of the needle on the tissue by the measured force, ∫ f_e dx_e.
        slave_port_energy_j: f64 = "energy from the slave", Joule, Neither [Never];
        /// Largest energy delivered by both ports beyond the energy received, max(E_s - E_m), by the measured force.
        generated_energy_j: f64 = "energy generated", Joule, Lower [WhereNonZero];
        /// Upper bound of the generated energy that the passivity scheme guarantees.
        promised_energy_j: Option<f64> = "energy that the scheme may generate", Joule, Neither [Never];
        /// Distance by which the slave is deeper than the hand at the last tick.
        left_behind_m: f64 = "needle left behind", Metre, Lower [Never];
        /// Energy that the passivity controller dissipated at the master.
        master_dissipated_j: f64 = "energy dissipated at the master", Joule, Neither [WhereNonZero];
        /// Work that the passivity controller withheld from the slave.
        slave_refused_j: f64 = "energy withheld from the slave", Joule, Neither [WhereNonZero];
    }
}

impl LinkMetrics {
    pub fn new(report: &LinkReport, grid: &TickGrid) -> Self {
        let seconds = |ticks: f64| grid.time_s(ticks as u64);
        Self {
            outages: report.outages,
            longest_outage_s: seconds(report.longest_outage_ticks),
            given_up_s: report.given_up_tick.map(seconds),
            master_port_energy_j: report.master_port_j,
            slave_port_energy_j: report.slave_port_j,
            generated_energy_j: report.generated_j,
            promised_energy_j: report.promised_j,
            left_behind_m: report.left_behind_m,
            master_dissipated_j: report.master_dissipated_j,
            slave_refused_j: report.slave_refused_j,
        }
    }
}

metrics! {
    /// Every metric of one run.
    #[derive(Debug, Clone, PartialEq, Serialize)]
    #[cfg_attr(feature = "schema", derive(schemars::JsonSchema), schemars(transform = crate::schema::with_units(Self::METRICS)))]
    pub struct Metrics in Run {
        /// The outcome of the run.
        outcome: Outcome;
        /// Time at which a position or force left its bounds and ended the run.
        diverged_s = "diverged at", Second, Neither [First] => |m| match m.outcome {
            Outcome::Completed | Outcome::Oscillating { .. } => None,
            Outcome::Diverged { time_s } => Some(time_s),
        };
        /// Number of ticks of the run.
        ticks: u64;
        /// One entry per rupture, in time order.
        ruptures: Vec<RuptureMetrics>;
        /// One entry per augmented event, in time order.
        events: Vec<EventMetrics>;
        /// The accepted alarms, in time order (the first 4096).
        alarms: Vec<Alarm>;
        /// Number of layers that ruptured in the run.
        ruptures = "ruptures", Count, Neither [Never] => |m| count(m.ruptures.len());
        /// Ruptures with an alarm within 0.1 s, after the force has fallen.
        detected_ruptures = "detected ruptures", Count, Higher [Never] => |m| {
            count(m.alarms.iter().filter(|alarm| alarm.matched).count())
        };
        /// Ruptures without an alarm within 0.1 s.
        missed_ruptures: u64 = "missed ruptures", Count, Lower [Main];
        /// Ruptures without an alarm, less than 0.1 s before the end of the run.
        undecided_ruptures: u64 = "undecided ruptures", Count, Neither [Never];
        /// Alarms without a rupture, or for a rupture that already had an alarm.
        false_alarms: u64 = "false alarms", Count, Lower [Main];
        /// Alarms without a rupture, per minute of the run.
        false_alarms_per_min = "false alarms per minute", Number, Lower [Never] => |m| {
            let ModeTimes { teleoperation_s, augmented_s, reengaging_s } = m.mode_times;
            let minutes = (teleoperation_s + augmented_s + reengaging_s) / 60.0;
            (minutes > 0.0).then(|| m.false_alarms as f64 / minutes)
        };
        /// Alarms ignored because an event was in progress or had just ended.
        ignored_alarms: u64 = "alarms ignored during or just after events", Count, Neither;
        /// Maximum detection delay of the run's ruptures.
        max_detection_delay_s = "maximum detection delay", Second, Lower [Never] => |m| {
            m.ruptures.iter().filter_map(|rupture| rupture.detection_delay_s).reduce(f64::max)
        };
        /// Maximum excess advance of the run's ruptures.
        max_excess_advance_m = "maximum excess advance", Metre, Lower [Never] => |m| {
            m.ruptures.iter().filter_map(|rupture| rupture.excess_advance_m).reduce(f64::max)
        };
        /// Maximum depth at return of the run's ruptures.
        max_depth_at_return_m = "maximum depth at return", Metre signed, Lower [Never] => |m| {
            m.ruptures.iter().filter_map(|rupture| rupture.depth_at_return_m).reduce(f64::max)
        };
        /// Sum of the unintended cuts of the run's ruptures.
        unintended_cut_m = "unintended cut", Metre, Lower [WhereDefined] => |m| {
            m.ruptures.iter().filter_map(|rupture| rupture.unintended_cut_m).reduce(|sum, cut_m| sum + cut_m)
        };
        /// Advance of the needle beyond the intended position at the last time at which the intended position was deepest, the end of the insertion.
        final_excess_m: Option<f64> = "final excess", Metre signed, Lower [WhereDefined];
        /// Distance by which the needle ends above the intended depth, at the end of the insertion; 0 if it ends at it or deeper.
        final_shortfall_m = "final shortfall", Metre, Lower [Never] => |m| m.final_excess_m.map(|excess_m| f64::max(-excess_m, 0.0));
        /// Ruptures that the operator noticed.
        noticed_ruptures = "noticed ruptures", Count, Higher [WhereDefined] => |m| {
            m.ruptures.iter().filter_map(|rupture| rupture.noticed.map(|noticed| noticed as f64)).reduce(|sum, one| sum + one)
        };
        /// Changes of the felt force noticed without a rupture or an event in the 2 s before, while the operator does not withdraw.
        false_notices: Option<u64> = "noticed without cause", Count, Lower [WhereDefined];
        /// Time without withdrawal outside the 2 s after ruptures and accepted alarms; undefined if the intended motion is unknown.
        undisturbed_s: Option<f64> = "undisturbed time", Second, Neither [Never];
        /// Total duration of the events that began with a false alarm, during which the slave is held and the insertion is delayed.
        false_alarm_event_s = "time in false events", Second, Lower [WhereDefined] => |m| {
            false_events(m).map(|event| event.augmented_s.unwrap_or(0.0) + event.reengaging_s.unwrap_or(0.0)).reduce(|sum, s| sum + s)
        };
        /// Largest change of the feedback force in an event that began with a false alarm.
        false_alarm_force_n = "force change by a false alarm", Newton, Lower [WhereDefined] => |m| {
            false_events(m).map(|event| event.force_change_n).reduce(f64::max)
        };
        /// Largest advance of the needle beyond the intended motion from a false alarm to the return to teleoperation.
        false_alarm_excess_m = "excess by a false alarm", Metre signed, Lower [WhereDefined] => |m| {
            false_events(m).filter_map(|event| event.excess_at_return_m).reduce(f64::max)
        };
        /// Maximum slave overshoot of the run's ruptures.
        max_slave_overshoot_m = "maximum slave overshoot", Metre, Lower [Never] => |m| {
            m.ruptures.iter().filter_map(|rupture| rupture.slave_overshoot_m).reduce(f64::max)
        };
        /// Maximum overshoot at 0.3 s of the run's ruptures.
        max_slave_travel_m = "maximum overshoot at 0.3 s", Metre signed, Lower [Never] => |m| {
            m.ruptures.iter().filter_map(|rupture| rupture.slave_travel_m).reduce(f64::max)
        };
        /// Minimum felt contrast of the run's ruptures.
        min_felt_contrast = "minimum felt contrast", Share, Higher [Never] => |m| {
            m.ruptures.iter().filter_map(|rupture| rupture.felt_contrast).reduce(f64::min)
        };
        /// Number of augmented events.
        events = "events", Count, Neither [Never] => |m| count(m.events.len());
        /// Mean of the absolute residual of the estimator, over the run.
        mean_absolute_residual_n: Option<f64> = "mean |residual|", Newton, Lower;
        /// Minimum tissue force on the needle; negative where it resists withdrawal.
        min_tissue_force_n: Option<f64> = "minimum tissue force", Newton signed, Neither;
        /// Maximum tissue force on the needle, positive where it resists insertion.
        max_tissue_force_n: Option<f64> = "maximum tissue force", Newton signed, Neither;
        /// Root mean square of the slave's distance from its reference, in teleoperation.
        tracking_rmse_m: Option<f64> = "tracking RMSE in teleoperation", Metre, Lower;
        /// Position of the slave at the last tick.
        final_slave_position_m: Option<f64> = "final slave position", Metre signed, Neither [Never];
        /// Distance of the slave from its reference at the last tick, relative to the reference: (x_ref - x_e) / x_ref.
        final_tracking_error: Option<f64> = "final tracking error", Share signed, Lower;
        /// Maximum distance of the slave from its position at the start of an event, up to its release, over all events.
        max_frozen_motion_m = "maximum motion while held", Metre, Lower => |m| {
            m.events.iter().map(|event| event.frozen_motion_m).reduce(f64::max)
        };
        /// Maximum speed of the slave while re-engaging, over all events.
        peak_reengaging_speed_m_per_s: Option<f64> = "peak slave speed while re-engaging", MetrePerSecond, Lower;
        /// Maximum change of the feedback force in one tick of an event beyond what its law allows; 0 apart from rounding.
        feedback_step_excess_n: f64 = "feedback force step beyond its limit", Newton signed, Lower;
        /// Time per mode.
        mode_times: ModeTimes;
        /// Time in teleoperation.
        teleoperation_s = "time in teleoperation", Second, Neither [Never] => |m| Some(m.mode_times.teleoperation_s);
        /// Total time from the start of an event to the release of the slave, over all events.
        augmented_s = "time augmented", Second, Neither => |m| Some(m.mode_times.augmented_s);
        /// Total time of re-engaging, over all events.
        reengaging_s = "time re-engaging", Second, Neither => |m| Some(m.mode_times.reengaging_s);
        /// Number of changes of mode.
        mode_switches: u64 = "mode switches", Count, Neither;
        /// Work of the hand on the master, ∫ F_h v_h dt.
        operator_energy_j: Option<f64> = "energy from the hand", Joule, Neither;
        /// Work of the needle on the tissue, ∫ f_e v_e dt.
        tissue_energy_j: Option<f64> = "energy into the tissue", Joule, Neither [Main];
        /// The link's metrics; `None` for a direct link.
        link: Option<LinkMetrics>;
        /// The energies at the ports. Reported only for runs with a trace.
        ports: Option<PortMetrics>;
    }
}

fn false_events(metrics: &Metrics) -> impl Iterator<Item = &EventMetrics> {
    metrics.events.iter().filter(|event| event.is_false == 1)
}

fn count(number: usize) -> Option<f64> {
    Some(number as f64)
}
