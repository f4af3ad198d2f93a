//! A lane's [`History`] changes rarely: at a rupture, an alarm, a change of mode or the end of a window. In between, an
//! open window's extremes are held here over lanes; at such a tick the lane's values are stored to the history, which
//! observes the tick, and loaded again.

use super::{History, RuptureWindow};
use crate::FALLEN_SHARE;
use crate::event::EventExtremes;
use crate::rupture::Extremes;
use trocar_core::augmentation::{Mode, Modes};
use trocar_core::lane::{Lane, Mask};
use trocar_engine::engine::Signals;

/// Per lane; with more open ruptures its history observes every tick.
const SLOTS: usize = 4;

const NEVER: f64 = f64::INFINITY;

#[derive(Debug, Clone, Copy)]
struct Slot<L> {
    next_tick: L,
    travel_tick: L,
    feedback_fallen_n: L,
    felt_fallen_n: L,
    extremes: Extremes<L>,
}

impl<L: Lane> Slot<L> {
    fn empty() -> Self {
        let (zero, none) = (L::zero(), L::splat(f64::NEG_INFINITY));
        Self {
            next_tick: L::splat(NEVER),
            travel_tick: zero,
            feedback_fallen_n: none,
            felt_fallen_n: none,
            extremes: Extremes::from_force(zero),
        }
    }

    #[inline(always)]
    fn needs_history(&self, now: L, s: &Signals<L>) -> L::Mask {
        now.ge(self.next_tick)
            | s.feedback_force_n.le(self.feedback_fallen_n)
            | s.operator_force_n.le(self.felt_fallen_n)
    }

    #[inline(always)]
    fn follow(&mut self, now: L, s: &Signals<L>) {
        self.extremes.observe(s, now.le(self.travel_tick));
    }

    fn load(&mut self, lane: usize, window: &RuptureWindow) {
        let travel_tick = window.tick + window.travel_ticks;
        let next_tick = if window.observed_ticks < window.travel_ticks {
            travel_tick
        } else {
            window.tick + window.window_ticks + 1
        };
        let fallen = |has_fallen: bool, before: f64| {
            if before > 0.0 && !has_fallen { FALLEN_SHARE * before } else { f64::NEG_INFINITY }
        };
        let set = |all: &mut L, value: f64| *all = all.with_lane(lane, value);
        set(&mut self.next_tick, next_tick as f64);
        set(&mut self.travel_tick, travel_tick as f64);
        set(&mut self.feedback_fallen_n, fallen(window.feedback_fallen_at.is_some(), window.feedback_n));
        set(&mut self.felt_fallen_n, fallen(window.felt_fallen_at.is_some(), window.felt_n));
        self.extremes = self.extremes.with_lane(lane, &window.extremes);
    }

    fn clear(&mut self, lane: usize) {
        self.next_tick = self.next_tick.with_lane(lane, NEVER);
        self.feedback_fallen_n = self.feedback_fallen_n.with_lane(lane, f64::NEG_INFINITY);
        self.felt_fallen_n = self.felt_fallen_n.with_lane(lane, f64::NEG_INFINITY);
    }

    fn store(&self, lane: usize, window: &mut RuptureWindow, tick: u64) {
        window.observed_ticks = tick - window.tick;
        window.extremes = self.extremes.lane(lane);
    }
}

#[derive(Debug, Clone)]
pub(super) struct OpenWindows<L: Lane> {
    slots: [Slot<L>; SLOTS],
    /// Per lane; above [`SLOTS`] its history observes every tick.
    in_use: Vec<usize>,
    max_in_use: usize,
    since: Vec<u64>,
    /// 1 until the lane diverges.
    runs: L,
    is_open: L,
    is_crowded: L,
    mode: Modes<L>,
    /// Valid for the present mode.
    event: EventExtremes<L>,
    step_excess_n: L,
}

impl<L: Lane> OpenWindows<L> {
    pub(super) fn new() -> Self {
        let zero = L::zero();
        Self {
            slots: [Slot::empty(); SLOTS],
            in_use: vec![0; L::WIDTH],
            max_in_use: 0,
            since: vec![0; L::WIDTH],
            runs: L::splat(1.0),
            is_open: zero,
            is_crowded: zero,
            mode: Modes::splat(Mode::Teleoperation),
            event: EventExtremes::at(zero, zero, zero),
            step_excess_n: zero,
        }
    }

    #[inline(always)]
    pub(super) fn running(&self) -> L::Mask {
        self.runs.gt(L::splat(0.5))
    }

    #[inline(always)]
    pub(super) fn any_open(&self) -> bool {
        self.is_open.gt(L::splat(0.5)).any()
    }

    #[inline(always)]
    pub(super) fn needs_history(&self, now: L, s: &Signals<L>, eventful: L::Mask) -> L::Mask {
        let half = L::splat(0.5);
        let mut needs_history = s.ruptured | s.alarm | s.noticed | self.is_crowded.gt(half) | s.mode.differs(self.mode);
        for slot in &self.slots[..self.max_in_use] {
            needs_history = needs_history | slot.needs_history(now, s);
        }
        needs_history & (eventful | self.is_open.gt(half))
    }

    /// The next load overwrites a lane that needs the history.
    #[inline(always)]
    pub(super) fn follow(&mut self, now: L, s: &Signals<L>, force_step_n: L) {
        for slot in &mut self.slots[..self.max_in_use] {
            slot.follow(now, s);
        }
        self.event.observe_held(s);
        self.event.observe_reengaging(s);
        self.step_excess_n = (force_step_n - s.allowed_force_step_n).max(self.step_excess_n);
    }

    pub(super) fn load(&mut self, lane: usize, history: &History, tick: u64) {
        let open = &history.ruptures[history.first_open..];
        self.in_use[lane] = open.len();
        self.max_in_use = self.in_use.iter().copied().max().unwrap_or(0).min(SLOTS);
        for (k, slot) in self.slots.iter_mut().enumerate() {
            match open.get(k) {
                Some(window) => slot.load(lane, window),
                None => slot.clear(lane),
            }
        }
        self.since[lane] = tick;
        let flag = |holds: bool| if holds { 1.0 } else { 0.0 };
        let set = |all: &mut L, value: f64| *all = all.with_lane(lane, value);
        set(&mut self.is_open, flag(history.has_open_window()));
        set(&mut self.is_crowded, flag(open.len() > SLOTS));
        self.mode = self.mode.with_lane(lane, history.mode);
        set(&mut self.step_excess_n, history.step_excess_n);
        if let Some(event) = history.events.last() {
            self.event = self.event.with_lane(lane, &event.extremes);
        }
    }

    pub(super) fn store(&self, lane: usize, history: &mut History, tick: u64) {
        let ticks = tick.saturating_sub(self.since[lane]);
        if ticks == 0 || self.is_open.lane(lane) == 0.0 && history.mode == Mode::Teleoperation {
            return;
        }
        for (slot, window) in self.slots.iter().zip(&mut history.ruptures[history.first_open..]) {
            slot.store(lane, window, tick);
        }
        history.mode_ticks[history.mode as usize] += ticks;
        if !history.is_event_open {
            return;
        }
        history.step_excess_n = self.step_excess_n.lane(lane);
        if let Some(event) = history.events.last_mut() {
            event.take(history.mode, &self.event.lane(lane));
        }
    }

    pub(super) fn end(&mut self, lane: usize) {
        self.runs = self.runs.with_lane(lane, 0.0);
        self.is_open = self.is_open.with_lane(lane, 0.0);
        for slot in &mut self.slots {
            slot.clear(lane);
        }
        self.in_use[lane] = 0;
    }
}
