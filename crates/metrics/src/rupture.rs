use serde::Serialize;

use super::intent::Aftermath;
use super::miss::Miss;
use super::{ALARM_WINDOW_S, FALLEN_SHARE, RUPTURE_WINDOW_S, TRAVEL_S};
use crate::metrics;
use trocar_core::lane::Lane;
use trocar_core::time::{TickGrid, nearest_ticks};
use trocar_engine::engine::Signals;

metrics! {
    /// The metrics of one rupture. "At the rupture" means the tick of the rupture, the last one under load. A metric
    /// over a window is undefined if the run ended before the window.
    #[derive(Debug, Clone, PartialEq, Serialize)]
    #[cfg_attr(feature = "schema", derive(schemars::JsonSchema), schemars(transform = crate::schema::with_units(Self::METRICS)))]
    pub struct RuptureMetrics in Rupture {
        /// Time at which the layer ruptured.
        time_s: f64 = "time", Second, Neither [Never];
        /// Name of the layer; `None` for a tissue without layers, or if the run is not recorded tick by tick.
        layer: Option<String>;
        /// Advance of the needle 0.3 s after the rupture; negative if it moved back.
        slave_travel_m: Option<f64> = "overshoot at 0.3 s", Metre signed, Lower [Main];
        /// Advance of the needle beyond the intended motion 0.3 s after the rupture; undefined if the intended motion is unknown.
        unintended_travel_m: Option<f64> = "unintended at 0.3 s", Metre signed, Lower [MainWhereDefined];
        /// Largest advance of the needle before the next rupture, within 2 s.
        deepest_advance_m: Option<f64> = "deepest point", Metre, Lower [Main];
        /// Largest advance of the needle beyond the intended motion before the next rupture, within 2 s; undefined if the intended motion is unknown.
        excess_advance_m: Option<f64> = "excess advance", Metre, Lower [MainWhereDefined];
        /// Time from the rupture to the return to teleoperation; undefined without an event.
        return_after_s: Option<f64> = "return after", Second, Neither [MainWhereDefined];
        /// Advance of the needle from its release to the return to teleoperation; undefined without an event.
        return_jump_m: Option<f64> = "jump of the return", Metre signed, Lower [MainWhereDefined];
        /// Advance of the needle at the next rupture, or after 2 s.
        horizon_advance_m: Option<f64> = "depth 2 s later", Metre signed, Neither [Main];
        /// Largest force on the hand from the rupture to 0.3 s after it.
        felt_peak_n: Option<f64> = "peak of the felt force", Newton signed, Neither [Main];
        /// Largest fall of the force on the hand from an earlier value, from the rupture to 0.3 s after it.
        felt_drop_n: Option<f64> = "drop of the felt force", Newton, Higher [Main];
        /// 1 if the operator noticed the rupture before the next one and within 2 s, else 0; undefined for an operator who cannot notice ruptures.
        noticed: Option<u64> = "noticed", Count, Higher [MainWhereDefined];
        /// Time from the rupture to its alarm, at most 0.1 s and after a fall of the force; undefined if the rupture was missed.
        detection_delay_s: Option<f64> = "detection delay", Second, Lower [Main];
        /// Advance of the needle from the rupture to the return to teleoperation; undefined without an event.
        depth_at_return_m: Option<f64> = "depth at return", Metre signed, Lower [WhereDefined];
        /// Largest depth of the needle beyond the largest intended depth before the next rupture, within 2 s.
        unintended_cut_m: Option<f64> = "unintended cut", Metre, Lower [WhereDefined];
        /// Time from the rupture until the operator noticed it.
        noticed_after_s: Option<f64> = "noticed after", Second, Lower [WhereDefined];
        /// Why the rupture was missed; `None` if it was not missed, or if the run is not recorded tick by tick.
        miss: Option<Miss>;
        /// Maximum advance of the needle in the 0.5 s after the rupture.
        slave_overshoot_m: Option<f64> = "overshoot in 0.5 s", Metre, Lower;
        /// Velocity of the master at the rupture.
        master_velocity_m_per_s: f64 = "master velocity", MetrePerSecond signed, Neither [Never];
        /// Position of the master at the rupture.
        master_position_m: f64 = "master position", Metre signed, Neither [Never];
        /// Maximum advance of the master in the 0.5 s after the rupture.
        master_travel_m: Option<f64> = "master travel in 0.5 s", Metre, Neither;
        /// Time until the feedback force has fallen to 5 % of its value at the rupture; undefined if it has not within 0.5 s.
        feedback_fall_s: Option<f64> = "feedback force down to 5 %", Second, Lower;
        /// Time until the force on the hand has fallen to 5 % of its value at the rupture; undefined if it has not within 0.5 s.
        felt_fall_s: Option<f64> = "felt force down to 5 %", Second, Lower;
        /// Maximum rate of change of the force on the hand in the 0.5 s after the rupture.
        peak_force_rate_n_per_s: Option<f64> = "peak rate of the felt force", NewtonPerSecond, Higher;
        /// Largest drop of the force on the hand within 0.3 s, relative to its value at the rupture; above 100 % the force pulls the hand.
        felt_contrast: Option<f64> = "felt contrast in 0.3 s", Share, Higher;
    }
}

#[derive(Debug, Clone, Copy)]
pub(super) struct Extremes<L> {
    pub(super) slave_m: L,
    pub(super) master_m: L,
    last_felt_n: L,
    overshoot_m: L,
    master_travel_m: L,
    peak_change_n: L,
    min_felt_n: L,
    max_felt_n: L,
    drop_n: L,
}

impl<L: Lane> Extremes<L> {
    pub(super) fn at(s: &Signals<L>) -> Self {
        Self { slave_m: s.slave_position_m, master_m: s.master_position_m, ..Self::from_force(s.operator_force_n) }
    }

    pub(super) fn from_force(felt_n: L) -> Self {
        let zero = L::zero();
        Self {
            slave_m: zero,
            master_m: zero,
            last_felt_n: felt_n,
            overshoot_m: zero,
            master_travel_m: zero,
            peak_change_n: zero,
            min_felt_n: felt_n,
            max_felt_n: felt_n,
            drop_n: zero,
        }
    }

    /// `is_early`: lanes that still update the felt force's extremes.
    #[inline(always)]
    pub(super) fn observe(&mut self, s: &Signals<L>, is_early: L::Mask) {
        let felt_n = s.operator_force_n;
        self.overshoot_m = (s.slave_position_m - self.slave_m).max(self.overshoot_m);
        self.master_travel_m = (s.master_position_m - self.master_m).max(self.master_travel_m);
        self.peak_change_n = (felt_n - self.last_felt_n).abs().max(self.peak_change_n);
        self.last_felt_n = felt_n;
        self.min_felt_n = L::select(is_early, felt_n.min(self.min_felt_n), self.min_felt_n);
        self.max_felt_n = L::select(is_early, felt_n.max(self.max_felt_n), self.max_felt_n);
        self.drop_n = L::select(is_early, (self.max_felt_n - felt_n).max(self.drop_n), self.drop_n);
    }

    pub(super) fn lane(&self, index: usize) -> Extremes<f64> {
        Extremes {
            slave_m: self.slave_m.lane(index),
            master_m: self.master_m.lane(index),
            last_felt_n: self.last_felt_n.lane(index),
            overshoot_m: self.overshoot_m.lane(index),
            master_travel_m: self.master_travel_m.lane(index),
            peak_change_n: self.peak_change_n.lane(index),
            min_felt_n: self.min_felt_n.lane(index),
            max_felt_n: self.max_felt_n.lane(index),
            drop_n: self.drop_n.lane(index),
        }
    }

    pub(super) fn with_lane(self, index: usize, one: &Extremes<f64>) -> Self {
        Self {
            slave_m: self.slave_m.with_lane(index, one.slave_m),
            master_m: self.master_m.with_lane(index, one.master_m),
            last_felt_n: self.last_felt_n.with_lane(index, one.last_felt_n),
            overshoot_m: self.overshoot_m.with_lane(index, one.overshoot_m),
            master_travel_m: self.master_travel_m.with_lane(index, one.master_travel_m),
            peak_change_n: self.peak_change_n.with_lane(index, one.peak_change_n),
            min_felt_n: self.min_felt_n.with_lane(index, one.min_felt_n),
            max_felt_n: self.max_felt_n.with_lane(index, one.max_felt_n),
            drop_n: self.drop_n.with_lane(index, one.drop_n),
        }
    }
}

#[derive(Debug, Clone, Copy)]
pub(super) struct Return {
    pub(super) tick: u64,
    pub(super) slave_m: f64,
    pub(super) released_m: Option<f64>,
}

#[derive(Debug, Clone)]
pub(super) struct RuptureWindow {
    pub(super) tick: u64,
    grid: TickGrid,
    pub(super) window_ticks: u64,
    pub(super) travel_ticks: u64,
    alarm_ticks: u64,
    tissue_n: f64,
    pub(super) feedback_n: f64,
    pub(super) felt_n: f64,
    pub(super) extremes: Extremes<f64>,
    detected_at: Option<u64>,
    travel_m: Option<f64>,
    /// The gap between needle and intended position at the rupture, and its growth until the travel is read.
    gap_m: Option<f64>,
    unintended_travel_m: Option<f64>,
    pub(super) feedback_fallen_at: Option<u64>,
    pub(super) felt_fallen_at: Option<u64>,
    pub(super) observed_ticks: u64,
    master_velocity_m_per_s: f64,
    pub(super) aftermath: Option<Aftermath>,
    pub(super) returned: Option<Return>,
    pub(super) noticed_at: Option<u64>,
}

impl RuptureWindow {
    pub(super) fn open(s: &Signals<f64>, grid: TickGrid, gap_m: Option<f64>) -> Self {
        Self {
            tick: s.tick,
            grid,
            window_ticks: nearest_ticks(RUPTURE_WINDOW_S, grid.tick_s()),
            travel_ticks: nearest_ticks(TRAVEL_S, grid.tick_s()),
            alarm_ticks: nearest_ticks(ALARM_WINDOW_S, grid.tick_s()),
            tissue_n: s.tissue_force_n,
            feedback_n: s.feedback_force_n,
            felt_n: s.operator_force_n,
            extremes: Extremes::at(s),
            detected_at: None,
            travel_m: None,
            gap_m,
            unintended_travel_m: None,
            feedback_fallen_at: None,
            felt_fallen_at: None,
            observed_ticks: 0,
            master_velocity_m_per_s: s.master_velocity_m_per_s,
            aftermath: None,
            returned: None,
            noticed_at: None,
        }
    }

    pub(super) fn contains(&self, tick: u64) -> bool {
        tick - self.tick <= self.window_ticks
    }

    /// Claims an alarm as the detection of this rupture; false if the rupture has an alarm, or if this one comes after
    /// [`ALARM_WINDOW_S`] or without a fall of the tissue force.
    pub(super) fn claim(&mut self, s: &Signals<f64>) -> bool {
        let has_fallen = s.tick == self.tick || s.tissue_force_n < self.tissue_n;
        let is_detection = self.detected_at.is_none() && s.tick - self.tick <= self.alarm_ticks && has_fallen;
        if is_detection {
            self.detected_at = Some(s.tick);
        }
        is_detection
    }

    #[inline(always)]
    pub(super) fn observe(&mut self, s: &Signals<f64>, gap_m: Option<f64>) {
        let since = s.tick - self.tick;
        self.observed_ticks = since;
        self.extremes.observe(s, since <= self.travel_ticks);
        if since == self.travel_ticks {
            self.travel_m = Some(s.slave_position_m - self.extremes.slave_m);
            self.unintended_travel_m = gap_m.zip(self.gap_m).map(|(now_m, before_m)| now_m - before_m);
        }
        let fallen = |force: f64, before: f64| before > 0.0 && force <= FALLEN_SHARE * before;
        if self.feedback_fallen_at.is_none() && fallen(s.feedback_force_n, self.feedback_n) {
            self.feedback_fallen_at = Some(s.tick);
        }
        if self.felt_fallen_at.is_none() && fallen(s.operator_force_n, self.felt_n) {
            self.felt_fallen_at = Some(s.tick);
        }
    }

    fn is_complete(&self) -> bool {
        self.observed_ticks >= self.window_ticks
    }

    pub(super) fn is_missed(&self) -> bool {
        self.detected_at.is_none() && self.observed_ticks >= self.alarm_ticks
    }

    pub(super) fn is_undecided(&self) -> bool {
        self.detected_at.is_none() && self.observed_ticks < self.alarm_ticks
    }

    pub(super) fn close(&self, notices: bool) -> RuptureMetrics {
        let (whole, extremes) = (self.is_complete(), &self.extremes);
        let is_read = self.observed_ticks >= self.travel_ticks;
        let since = |tick: u64| self.grid.time_s(tick - self.tick);
        let beyond_intent_m = self.aftermath.and_then(|aftermath| aftermath.beyond_intent_m);
        RuptureMetrics {
            time_s: self.grid.time_s(self.tick),
            detection_delay_s: self.detected_at.map(since),
            layer: None,
            miss: None,
            excess_advance_m: beyond_intent_m.map(|(excess_m, _)| excess_m),
            unintended_travel_m: self.unintended_travel_m,
            deepest_advance_m: self.aftermath.map(|aftermath| aftermath.deepest_m),
            horizon_advance_m: self.aftermath.map(|aftermath| aftermath.advance_m),
            return_after_s: self.returned.map(|returned| since(returned.tick)),
            return_jump_m: self.returned.and_then(|returned| Some(returned.slave_m - returned.released_m?)),
            depth_at_return_m: self.returned.map(|returned| returned.slave_m - extremes.slave_m),
            felt_peak_n: is_read.then_some(extremes.max_felt_n),
            felt_drop_n: is_read.then_some(extremes.drop_n),
            unintended_cut_m: beyond_intent_m.map(|(_, cut_m)| cut_m),
            noticed: (notices && (self.noticed_at.is_some() || self.aftermath.is_some()))
                .then_some(u64::from(self.noticed_at.is_some())),
            noticed_after_s: self.noticed_at.map(since),
            slave_overshoot_m: whole.then_some(extremes.overshoot_m),
            slave_travel_m: self.travel_m,
            master_velocity_m_per_s: self.master_velocity_m_per_s,
            master_position_m: extremes.master_m,
            master_travel_m: whole.then_some(extremes.master_travel_m),
            feedback_fall_s: self.feedback_fallen_at.map(since),
            felt_fall_s: self.felt_fallen_at.map(since),
            peak_force_rate_n_per_s: whole.then(|| extremes.peak_change_n / self.grid.tick_s()),
            felt_contrast: (is_read && self.felt_n > 0.0).then(|| 1.0 - extremes.min_felt_n / self.felt_n),
        }
    }
}
