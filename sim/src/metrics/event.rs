//! The metrics of one augmented event.

use serde::Serialize;

use super::catalogue::metrics;
use crate::augmentation::Mode;
use crate::engine::Signals;
use crate::time::TickGrid;

metrics! {
    /// The metrics of one event, from the alarm to the return to teleoperation.
    #[derive(Debug, Clone, PartialEq, Serialize)]
    pub struct EventMetrics in Event {
        /// Time at which the alarm was accepted and the slave was frozen.
        start_s: f64 = "start", Second, Neither [Never];
        /// Duration of the freeze; undefined if the run ended before.
        augmented_s: Option<f64> = "time augmented", Second, Neither [Never];
        /// Duration of re-engaging; undefined if the run ended before.
        reengaging_s: Option<f64> = "time re-engaging", Second, Lower [Never];
        /// Position of the master when the slave was frozen.
        master_start_m: f64 = "master position at the start", Metre signed, Neither [Never];
        /// Position of the master when the slave was released, or at the last frozen tick.
        master_end_m: f64 = "master position at the release", Metre signed, Neither [Never];
        /// Maximum distance of the frozen slave from its position at the freeze.
        frozen_motion_m: f64 = "motion while frozen", Metre, Lower [Never];
        /// Maximum speed of the slave while re-engaging; undefined if it did not re-engage.
        peak_reengaging_speed_m_per_s: Option<f64> = "peak slave speed re-engaging", MetrePerSecond, Lower [Never];
        /// Change of the feedback force in the first tick of the event.
        entry_step_n: f64 = "force step at the start", Newton, Lower [Never];
        /// Change of the feedback force that its law allows in the first tick of the event.
        entry_step_allowed_n: f64 = "allowed force step at the start", Newton, Neither [Never];
        /// Change of the feedback force in the first tick of re-engaging.
        exit_step_n: Option<f64> = "force step at the release", Newton, Lower [Never];
        /// Change of the feedback force that its law allows in the first tick of re-engaging.
        exit_step_allowed_n: Option<f64> = "allowed force step at the release", Newton, Neither [Never];
    }
}

/// An open event.
#[derive(Debug, Clone)]
pub(super) struct EventWindow {
    start: u64,
    released: Option<u64>,
    ended: Option<u64>,
    pub(super) slave_start_m: f64,
    pub(super) metrics: EventMetrics,
}

impl EventWindow {
    pub(super) fn open(s: &Signals<f64>, step_n: f64, grid: &TickGrid) -> Self {
        Self {
            start: s.tick,
            released: None,
            ended: None,
            slave_start_m: s.slave_position_m,
            metrics: EventMetrics {
                start_s: grid.time_s(s.tick),
                augmented_s: None,
                reengaging_s: None,
                master_start_m: s.master_position_m,
                master_end_m: s.master_position_m,
                frozen_motion_m: 0.0,
                peak_reengaging_speed_m_per_s: None,
                entry_step_n: step_n,
                entry_step_allowed_n: s.allowed_force_step_n,
                exit_step_n: None,
                exit_step_allowed_n: None,
            },
        }
    }

    /// Processes a tick; returns whether the event is still open.
    pub(super) fn observe(&mut self, s: &Signals<f64>, step_n: f64) -> bool {
        let m = &mut self.metrics;
        if s.mode == Mode::Augmented.code() {
            m.master_end_m = s.master_position_m;
            m.frozen_motion_m = m.frozen_motion_m.max((s.slave_position_m - self.slave_start_m).abs());
        } else if s.mode == Mode::Reengaging.code() {
            if self.released.is_none() {
                self.released = Some(s.tick);
                m.master_end_m = s.master_position_m;
                m.exit_step_n = Some(step_n);
                m.exit_step_allowed_n = Some(s.allowed_force_step_n);
            }
            let speed = s.slave_velocity_m_per_s.abs();
            let peak = m.peak_reengaging_speed_m_per_s.map_or(speed, |peak| peak.max(speed));
            m.peak_reengaging_speed_m_per_s = Some(peak);
        } else {
            self.ended = Some(s.tick);
            return false;
        }
        true
    }

    pub(super) fn close(&self, grid: &TickGrid) -> EventMetrics {
        let span = |from: u64, to: u64| grid.time_s(to - from);
        EventMetrics {
            augmented_s: self.released.map(|released| span(self.start, released)),
            reengaging_s: self.released.zip(self.ended).map(|(released, ended)| span(released, ended)),
            ..self.metrics.clone()
        }
    }
}
