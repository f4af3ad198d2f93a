use serde::Serialize;

use crate::metrics;
use trocar_core::augmentation::Mode;
use trocar_core::lane::Lane;
use trocar_core::time::TickGrid;
use trocar_engine::engine::Signals;

metrics! {
    /// The metrics of one event, from the alarm to the return to teleoperation.
    #[derive(Debug, Clone, PartialEq, Serialize)]
    #[cfg_attr(feature = "schema", derive(schemars::JsonSchema), schemars(transform = crate::schema::with_units(Self::METRICS)))]
    pub struct EventMetrics in Event {
        /// Time at which the alarm was accepted.
        start_s: f64 = "start", Second, Neither [Never];
        /// Time from the start to the release of the slave; undefined if the run ended before the release.
        augmented_s: Option<f64> = "time augmented", Second, Neither [Never];
        /// Duration of re-engaging; undefined if the run ended before the return to teleoperation.
        reengaging_s: Option<f64> = "time re-engaging", Second, Lower [Never];
        /// Position of the master at the start.
        master_start_m: f64 = "master position at the start", Metre signed, Neither [Never];
        /// Position of the master when the slave was released, or at the last tick of a run that ended before the release.
        master_end_m: f64 = "master position at the release", Metre signed, Neither [Never];
        /// Maximum distance of the slave from its position at the start, up to its release.
        frozen_motion_m: f64 = "motion while held", Metre, Lower [Never];
        /// Maximum speed of the slave while re-engaging; undefined if it did not re-engage.
        peak_reengaging_speed_m_per_s: Option<f64> = "peak slave speed while re-engaging", MetrePerSecond, Lower [Never];
        /// 1 if the event began with a false alarm, else 0.
        is_false: u64 = "false alarm", Count, Lower [Never];
        /// Largest change of the feedback force from its value at the start.
        force_change_n: f64 = "change of the feedback force", Newton, Neither [Never];
        /// Advance of the needle beyond the intended motion from the start to the return to teleoperation.
        excess_at_return_m: Option<f64> = "excess at return", Metre signed, Lower [Never];
        /// 1 if the operator noticed a change of the felt force within 2 s of the start, else 0.
        noticed: Option<u64> = "noticed", Count, Neither [Never];
        /// Change of the feedback force in the first tick of the event.
        entry_step_n: f64 = "force step at the start", Newton, Lower [Never];
        /// Change of the feedback force that its force law allows in the first tick of the event.
        entry_step_allowed_n: f64 = "allowed force step at the start", Newton, Neither [Never];
        /// Change of the feedback force in the first tick of re-engaging.
        exit_step_n: Option<f64> = "force step at the release", Newton, Lower [Never];
        /// Change of the feedback force that its force law allows in the first tick of re-engaging.
        exit_step_allowed_n: Option<f64> = "allowed force step at the release", Newton, Neither [Never];
    }
}

/// Values of an event that change at every tick.
#[derive(Debug, Clone, Copy)]
pub(super) struct EventExtremes<L> {
    slave_start_m: L,
    master_end_m: L,
    frozen_motion_m: L,
    peak_speed_m_per_s: L,
    feedback_start_n: L,
    force_change_n: L,
}

impl<L: Lane> EventExtremes<L> {
    pub(super) fn at(slave_m: L, master_m: L, feedback_n: L) -> Self {
        Self {
            slave_start_m: slave_m,
            master_end_m: master_m,
            frozen_motion_m: L::zero(),
            peak_speed_m_per_s: L::splat(f64::NEG_INFINITY),
            feedback_start_n: feedback_n,
            force_change_n: L::zero(),
        }
    }

    #[inline(always)]
    pub(super) fn observe_held(&mut self, s: &Signals<L>) {
        self.master_end_m = s.master_position_m;
        self.frozen_motion_m = (s.slave_position_m - self.slave_start_m).abs().max(self.frozen_motion_m);
        self.observe_force(s);
    }

    #[inline(always)]
    pub(super) fn observe_reengaging(&mut self, s: &Signals<L>) {
        self.peak_speed_m_per_s = s.slave_velocity_m_per_s.abs().max(self.peak_speed_m_per_s);
        self.observe_force(s);
    }

    #[inline(always)]
    fn observe_force(&mut self, s: &Signals<L>) {
        self.force_change_n = (s.feedback_force_n - self.feedback_start_n).abs().max(self.force_change_n);
    }

    pub(super) fn lane(&self, index: usize) -> EventExtremes<f64> {
        EventExtremes {
            slave_start_m: self.slave_start_m.lane(index),
            master_end_m: self.master_end_m.lane(index),
            frozen_motion_m: self.frozen_motion_m.lane(index),
            peak_speed_m_per_s: self.peak_speed_m_per_s.lane(index),
            feedback_start_n: self.feedback_start_n.lane(index),
            force_change_n: self.force_change_n.lane(index),
        }
    }

    pub(super) fn with_lane(self, index: usize, one: &EventExtremes<f64>) -> Self {
        Self {
            slave_start_m: self.slave_start_m.with_lane(index, one.slave_start_m),
            master_end_m: self.master_end_m.with_lane(index, one.master_end_m),
            frozen_motion_m: self.frozen_motion_m.with_lane(index, one.frozen_motion_m),
            peak_speed_m_per_s: self.peak_speed_m_per_s.with_lane(index, one.peak_speed_m_per_s),
            feedback_start_n: self.feedback_start_n.with_lane(index, one.feedback_start_n),
            force_change_n: self.force_change_n.with_lane(index, one.force_change_n),
        }
    }
}

#[derive(Debug, Clone, Copy)]
pub(super) struct Beginning {
    /// The first rupture whose needle the event holds; the number of ruptures for a false alarm.
    pub(super) first_rupture: usize,
    pub(super) is_false: bool,
    pub(super) gap_m: Option<f64>,
}

#[derive(Debug, Clone)]
pub(super) struct EventWindow {
    pub(super) start: u64,
    released: Option<u64>,
    pub(super) released_m: Option<f64>,
    ended: Option<u64>,
    pub(super) beginning: Beginning,
    pub(super) excess_m: Option<f64>,
    pub(super) noticed_at: Option<u64>,
    master_start_m: f64,
    pub(super) extremes: EventExtremes<f64>,
    /// The change of the feedback force and the allowed change, at the start and at the release.
    entry_step_n: [f64; 2],
    exit_step_n: Option<[f64; 2]>,
}

impl EventWindow {
    pub(super) fn open(s: &Signals<f64>, step_n: f64, beginning: Beginning) -> Self {
        Self {
            start: s.tick,
            released: None,
            released_m: None,
            ended: None,
            beginning,
            excess_m: None,
            noticed_at: None,
            master_start_m: s.master_position_m,
            extremes: EventExtremes::at(s.slave_position_m, s.master_position_m, s.feedback_force_n),
            entry_step_n: [step_n, s.allowed_force_step_n],
            exit_step_n: None,
        }
    }

    pub(super) fn observe(&mut self, s: &Signals<f64>, step_n: f64) -> bool {
        match s.mode.lane(0) {
            Mode::Augmented => self.extremes.observe_held(s),
            Mode::Reengaging => {
                if self.released.is_none() {
                    self.released = Some(s.tick);
                    self.released_m = Some(s.slave_position_m);
                    self.extremes.master_end_m = s.master_position_m;
                    self.exit_step_n = Some([step_n, s.allowed_force_step_n]);
                }
                self.extremes.observe_reengaging(s);
            }
            Mode::Teleoperation => {
                self.ended = Some(s.tick);
                return false;
            }
        }
        true
    }

    pub(super) fn take(&mut self, mode: Mode, kept: &EventExtremes<f64>) {
        match mode {
            Mode::Augmented => {
                self.extremes.master_end_m = kept.master_end_m;
                self.extremes.frozen_motion_m = kept.frozen_motion_m;
            }
            Mode::Reengaging => self.extremes.peak_speed_m_per_s = kept.peak_speed_m_per_s,
            Mode::Teleoperation => {}
        }
        self.extremes.force_change_n = kept.force_change_n;
    }

    pub(super) fn close(&self, grid: &TickGrid, notices: bool) -> EventMetrics {
        let span = |from: u64, to: u64| grid.time_s(to - from);
        EventMetrics {
            start_s: grid.time_s(self.start),
            augmented_s: self.released.map(|released| span(self.start, released)),
            reengaging_s: self.released.zip(self.ended).map(|(released, ended)| span(released, ended)),
            master_start_m: self.master_start_m,
            master_end_m: self.extremes.master_end_m,
            frozen_motion_m: self.extremes.frozen_motion_m,
            peak_reengaging_speed_m_per_s: self.released.map(|_| self.extremes.peak_speed_m_per_s),
            is_false: u64::from(self.beginning.is_false),
            force_change_n: self.extremes.force_change_n,
            excess_at_return_m: self.excess_m,
            noticed: notices.then_some(u64::from(self.noticed_at.is_some())),
            entry_step_n: self.entry_step_n[0],
            entry_step_allowed_n: self.entry_step_n[1],
            exit_step_n: self.exit_step_n.map(|[step_n, _]| step_n),
            exit_step_allowed_n: self.exit_step_n.map(|[_, allowed_n]| allowed_n),
        }
    }
}
