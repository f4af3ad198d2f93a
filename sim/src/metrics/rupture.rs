//! What happened after one rupture.

use serde::Serialize;

use super::{FALLEN_SHARE, RUPTURE_WINDOW_S, TRAVEL_S};
use crate::engine::Signals;
use crate::time::{TickGrid, nearest_ticks};

/// The numbers of one rupture. "Before" is the tick of the rupture itself, the last one under load.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct RuptureMetrics {
    /// When the layer gave way, in s.
    pub time_s: f64,
    /// From the rupture to the alarm that announced it, in s; none if missed.
    pub detection_delay_s: Option<f64>,
    /// Greatest advance of the slave within the window, in m; none, as with the next ones, if the run ended before.
    pub slave_overshoot_m: Option<f64>,
    /// Advance of the slave at 0.3 s, in m; none if the run ended before.
    pub slave_travel_m: Option<f64>,
    /// The master's position at the rupture, in m.
    pub master_position_m: f64,
    /// Greatest advance of the master within the window, in m.
    pub master_travel_m: Option<f64>,
    /// Until the fed-back force had fallen to 5 % of its value before, in s; none if it did not within the window, or
    /// did not resist before.
    pub feedback_fall_s: Option<f64>,
    /// Until the force on the hand had, in s; none likewise.
    pub felt_fall_s: Option<f64>,
    /// Steepest change of the force on the hand within the window, in N/s.
    pub peak_force_rate_n_per_s: Option<f64>,
    /// `1 - min F_h / F_h before`, the minimum within 0.3 s; none if the hand felt no resistance before, or the run
    /// ended earlier.
    pub felt_contrast: Option<f64>,
}

/// A rupture's window while it is open.
#[derive(Debug, Clone)]
pub(super) struct RuptureWindow {
    pub(super) tick: u64,
    grid: TickGrid,
    pub(super) window_ticks: u64,
    pub(super) travel_ticks: u64,
    pub(super) slave_m: f64,
    pub(super) master_m: f64,
    pub(super) feedback_n: f64,
    pub(super) felt_n: f64,
    pub(super) last_felt_n: f64,
    detected_at: Option<u64>,
    pub(super) overshoot_m: f64,
    travel_m: Option<f64>,
    pub(super) master_travel_m: f64,
    pub(super) feedback_fallen_at: Option<u64>,
    pub(super) felt_fallen_at: Option<u64>,
    /// Greatest change of the force on the hand in a tick, in N.
    pub(super) peak_change_n: f64,
    pub(super) min_felt_n: f64,
    pub(super) seen: u64,
}

impl RuptureWindow {
    pub(super) fn open(s: &Signals<f64>, grid: TickGrid) -> Self {
        Self {
            tick: s.tick,
            grid,
            window_ticks: nearest_ticks(RUPTURE_WINDOW_S, grid.tick_s()),
            travel_ticks: nearest_ticks(TRAVEL_S, grid.tick_s()),
            slave_m: s.slave_position_m,
            master_m: s.master_position_m,
            feedback_n: s.feedback_force_n,
            felt_n: s.operator_force_n,
            last_felt_n: s.operator_force_n,
            detected_at: None,
            overshoot_m: 0.0,
            travel_m: None,
            master_travel_m: 0.0,
            feedback_fallen_at: None,
            felt_fallen_at: None,
            peak_change_n: 0.0,
            min_felt_n: s.operator_force_n,
            seen: 0,
        }
    }

    /// Whether a tick belongs to the window.
    pub(super) fn contains(&self, tick: u64) -> bool {
        tick - self.tick <= self.window_ticks
    }

    /// Takes an alarm as this rupture's detection, if it has none yet.
    pub(super) fn claim(&mut self, tick: u64) -> bool {
        let free = self.detected_at.is_none();
        if free {
            self.detected_at = Some(tick);
        }
        free
    }

    /// Takes a tick after the rupture.
    #[inline(always)]
    pub(super) fn observe(&mut self, s: &Signals<f64>) {
        let since = s.tick - self.tick;
        self.seen = since;
        self.overshoot_m = self.overshoot_m.max(s.slave_position_m - self.slave_m);
        self.master_travel_m = self.master_travel_m.max(s.master_position_m - self.master_m);
        if since == self.travel_ticks {
            self.travel_m = Some(s.slave_position_m - self.slave_m);
        }
        let fallen = |force: f64, before: f64| before > 0.0 && force <= FALLEN_SHARE * before;
        if self.feedback_fallen_at.is_none() && fallen(s.feedback_force_n, self.feedback_n) {
            self.feedback_fallen_at = Some(s.tick);
        }
        if self.felt_fallen_at.is_none() && fallen(s.operator_force_n, self.felt_n) {
            self.felt_fallen_at = Some(s.tick);
        }
        self.peak_change_n = self.peak_change_n.max((s.operator_force_n - self.last_felt_n).abs());
        self.last_felt_n = s.operator_force_n;
        if since <= self.travel_ticks {
            self.min_felt_n = self.min_felt_n.min(s.operator_force_n);
        }
    }

    /// Whether the run saw the whole window.
    fn is_complete(&self) -> bool {
        self.seen >= self.window_ticks
    }

    /// Whether nothing announced the rupture in its whole window.
    pub(super) fn is_missed(&self) -> bool {
        self.detected_at.is_none() && self.is_complete()
    }

    /// Whether nothing announced it before the run ended within its window.
    pub(super) fn is_undecided(&self) -> bool {
        self.detected_at.is_none() && !self.is_complete()
    }

    pub(super) fn close(&self) -> RuptureMetrics {
        let whole = self.is_complete();
        let felt = self.seen >= self.travel_ticks && self.felt_n > 0.0;
        let since = |tick: u64| self.grid.time_s(tick - self.tick);
        RuptureMetrics {
            time_s: self.grid.time_s(self.tick),
            detection_delay_s: self.detected_at.map(since),
            slave_overshoot_m: whole.then_some(self.overshoot_m),
            slave_travel_m: self.travel_m,
            master_position_m: self.master_m,
            master_travel_m: whole.then_some(self.master_travel_m),
            feedback_fall_s: self.feedback_fallen_at.map(since),
            felt_fall_s: self.felt_fallen_at.map(since),
            peak_force_rate_n_per_s: whole.then(|| self.peak_change_n / self.grid.tick_s()),
            felt_contrast: felt.then(|| 1.0 - self.min_felt_n / self.felt_n),
        }
    }
}
