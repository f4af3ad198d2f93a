//! From ticks to metrics.

mod live;

use self::live::Live;
use super::event::EventWindow;
use super::rupture::RuptureWindow;
use super::sums::{Sample, Sums};
use super::{Alarm, DIVERGED_M, Metrics, ModeTimes, Outcome};
use crate::augmentation::Mode;
use crate::engine::{Observer, Signals};
use crate::lane::{Lane, Mask};
use crate::time::TickGrid;

/// Most ruptures, events and alarms of one run that are looked at one by one.
const MAX_KEPT: usize = 4096;

/// Measured force in N beyond which a run has diverged: no needle meets a millionth of it. NaN is beyond
/// any bound.
const DIVERGED_N: f64 = 1e9;

/// A tick's signals that only count if it is the run's last.
#[derive(Debug, Clone, Copy)]
struct Last<L> {
    slave_m: L,
    reference_m: L,
    operator_power_w: L,
    tissue_power_w: L,
}

impl<L: Lane> Last<L> {
    #[inline(always)]
    fn of(sample: &Sample<L>) -> Self {
        Self {
            slave_m: sample.slave_m,
            reference_m: sample.reference_m,
            operator_power_w: sample.operator_power_w,
            tissue_power_w: sample.tissue_power_w,
        }
    }

    fn lane(&self, index: usize) -> Last<f64> {
        Last {
            slave_m: self.slave_m.lane(index),
            reference_m: self.reference_m.lane(index),
            operator_power_w: self.operator_power_w.lane(index),
            tissue_power_w: self.tissue_power_w.lane(index),
        }
    }
}

/// What is summed of a tick.
#[inline(always)]
fn sample<L: Lane>(s: &Signals<L>) -> Sample<L> {
    Sample {
        residual_n: s.residual_n,
        slave_m: s.slave_position_m,
        reference_m: s.slave_reference_m,
        operator_power_w: s.operator_force_n * s.master_velocity_m_per_s,
        tissue_power_w: s.tissue_force_n * s.slave_velocity_m_per_s,
        tissue_force_n: s.tissue_force_n,
    }
}

/// A copy for a tick that is looked at closely. Nothing there looks at the estimates: without them, fewer numbers wait in each
/// tick for it.
#[inline(always)]
fn seen<L: Lane>(s: &Signals<L>) -> Signals<L> {
    let zero = L::zero();
    let nothing = Signals { desired_position_m: zero, stiffness_n_per_m: zero, damping_n_s_per_m: zero, ..*s };
    Signals { distance: zero, decision: zero, ..nothing }
}

/// What one lane has lived through, kept apart from the sums as it seldom changes.
#[derive(Debug, Clone)]
struct History {
    ruptures: Vec<RuptureWindow>,
    /// Windows before this one have closed.
    first_open: usize,
    events: Vec<EventWindow>,
    event_goes_on: bool,
    alarms: Vec<Alarm>,
    false_alarms: u64,
    ignored_alarms: u64,
    mode: f64,
    mode_ticks: [u64; 3],
    mode_switches: u64,
    step_excess_n: f64,
    diverged_at: Option<u64>,
    /// The last tick before the divergence.
    last_sound: Option<Last<f64>>,
}

impl History {
    fn new(ruptures: usize) -> Self {
        Self {
            ruptures: Vec::with_capacity(ruptures.min(MAX_KEPT)),
            first_open: 0,
            events: Vec::with_capacity(ruptures.clamp(16, MAX_KEPT)),
            event_goes_on: false,
            alarms: Vec::with_capacity(MAX_KEPT),
            false_alarms: 0,
            ignored_alarms: 0,
            mode: Mode::Teleoperation.code(),
            mode_ticks: [0; 3],
            mode_switches: 0,
            step_excess_n: 0.0,
            diverged_at: None,
            last_sound: None,
        }
    }

    fn has_open_window(&self) -> bool {
        self.first_open < self.ruptures.len() || self.event_goes_on
    }

    /// A tick at which something happens or is still happening.
    #[inline(always)]
    fn observe(&mut self, s: &Signals<f64>, force_step_n: f64, grid: &TickGrid) {
        while self.ruptures.get(self.first_open).is_some_and(|rupture| !rupture.contains(s.tick)) {
            self.first_open += 1;
        }
        for rupture in &mut self.ruptures[self.first_open..] {
            rupture.observe(s);
        }
        // Before the alarms: one at the very tick of a rupture is its detection.
        if s.ruptured && self.ruptures.len() < MAX_KEPT {
            self.ruptures.push(RuptureWindow::open(s, *grid));
        }
        if s.alarm_taken {
            // The latest rupture first: an alarm is about what has just happened.
            let matched = self.ruptures[self.first_open..].iter_mut().rev().any(|rupture| rupture.claim(s.tick));
            self.false_alarms += u64::from(!matched);
            if self.alarms.len() < MAX_KEPT {
                self.alarms.push(Alarm { time_s: grid.time_s(s.tick), matched });
            }
        } else if s.alarm {
            self.ignored_alarms += 1;
        }
        self.mode_ticks[s.mode as usize] += 1;
        self.observe_event(s, force_step_n, grid);
    }

    #[inline(always)]
    fn observe_event(&mut self, s: &Signals<f64>, step: f64, grid: &TickGrid) {
        if self.event_goes_on || s.mode != self.mode {
            self.step_excess_n = self.step_excess_n.max(step - s.allowed_force_step_n);
        }
        if s.mode == Mode::Augmented.code() && self.mode == Mode::Teleoperation.code() && self.events.len() < MAX_KEPT {
            self.events.push(EventWindow::open(s, step, grid));
            self.event_goes_on = true;
        }
        if self.event_goes_on {
            self.event_goes_on = self.events.last_mut().is_some_and(|event| event.observe(s, step));
        }
        self.mode_switches += u64::from(s.mode != self.mode);
        self.mode = s.mode;
    }
}

/// Computes every metric of a run while it runs.
#[derive(Debug, Clone)]
pub struct MetricsObserver<L: Lane> {
    grid: TickGrid,
    ticks: u64,
    sums: Sums<L>,
    first: Last<L>,
    /// The last tick that was looked at closely, and what came of it: the sums hold it masked.
    last_close: (u64, Last<L>),
    histories: Vec<History>,
    /// Of several lanes, what goes on in them.
    live: Option<Box<Live<L>>>,
    /// Lanes that have not diverged.
    running: usize,
    /// Whether the next tick is looked at closely, whatever it brings: the first, and while something goes on.
    is_watching: bool,
    last_commanded_n: L,
}

impl<L: Lane> MetricsObserver<L> {
    /// An observer with room for an expected number of ruptures; more are taken, at the price of an allocation.
    #[must_use]
    pub fn new(grid: TickGrid, expected_ruptures: usize) -> Self {
        let zero = L::zero();
        let nothing = Last { slave_m: zero, reference_m: zero, operator_power_w: zero, tissue_power_w: zero };
        Self {
            grid,
            ticks: 0,
            sums: Sums::new(),
            first: nothing,
            last_close: (0, nothing),
            histories: (0..L::WIDTH).map(|_| History::new(expected_ruptures)).collect(),
            live: (L::WIDTH > 1).then(|| Box::new(Live::new())),
            running: L::WIDTH,
            is_watching: true,
            last_commanded_n: zero,
        }
    }

    /// The metrics of lane `index`.
    #[must_use]
    pub fn metrics(&self, index: usize) -> Metrics {
        let mut history = std::borrow::Cow::Borrowed(&self.histories[index]);
        if let Some(live) = self.live.as_ref().filter(|_| history.diverged_at.is_none()) {
            live.store(index, history.to_mut(), self.ticks.saturating_sub(1));
        }
        let ticks = history.diverged_at.unwrap_or(self.ticks);
        let tick_s = self.grid.tick_s();
        let ran = ticks > 0;
        let mean = |sum: f64, count: f64| (count > 0.0).then(|| sum / count);
        let totals = self.sums.totals_of(index, self.ticks);
        let (first, last) = (self.first.lane(index), history.last_sound.unwrap_or(self.last(self.ticks).lane(index)));
        let energy = |sum: f64, first: f64, last: f64| ran.then_some((sum - 0.5 * (first + last)) * tick_s);
        let (slave_m, reference_m) = (last.slave_m, last.reference_m);
        let events: Vec<_> = history.events.iter().map(|event| event.close(&self.grid)).collect();
        let ruptures: Vec<_> = history.ruptures.iter().map(RuptureWindow::close).collect();
        let count =
            |is: &dyn Fn(&RuptureWindow) -> bool| history.ruptures.iter().filter(|window| is(window)).count() as u64;
        let [_, augmented, reengaging] = history.mode_ticks;
        let following = ticks - augmented - reengaging;
        let peak = events.iter().filter_map(|event| event.peak_reengaging_speed_m_per_s).reduce(f64::max);
        Metrics {
            outcome: history
                .diverged_at
                .map_or(Outcome::Completed, |tick| Outcome::Diverged { time_s: self.grid.time_s(tick) }),
            ticks,
            missed_ruptures: count(&|window| window.is_missed()),
            undecided_ruptures: count(&|window| window.is_undecided()),
            alarms: history.alarms.clone(),
            false_alarms: history.false_alarms,
            ignored_alarms: history.ignored_alarms,
            mean_absolute_residual_n: mean(totals.absolute_residual_n, ticks as f64),
            min_tissue_force_n: ran.then_some(totals.min_force_n),
            max_tissue_force_n: ran.then_some(totals.max_force_n),
            tracking_rmse_m: mean(totals.squared_tracking_error_m2, following as f64).map(f64::sqrt),
            final_slave_position_m: ran.then_some(slave_m),
            final_tracking_error: (ran && reference_m != 0.0).then(|| (reference_m - slave_m) / reference_m),
            peak_reengaging_speed_m_per_s: peak,
            feedback_step_excess_n: history.step_excess_n,
            mode_times: ModeTimes {
                teleoperation_s: following as f64 * tick_s,
                augmented_s: augmented as f64 * tick_s,
                reengaging_s: reengaging as f64 * tick_s,
            },
            mode_switches: history.mode_switches,
            operator_energy_j: energy(totals.operator_power_w, first.operator_power_w, last.operator_power_w),
            tissue_energy_j: energy(totals.tissue_power_w, first.tissue_power_w, last.tissue_power_w),
            ruptures,
            events,
            link: None,
        }
    }

    /// The last of the first `ticks` ticks.
    fn last(&self, ticks: u64) -> Last<L> {
        let (tick, last) = self.last_close;
        if tick + 1 >= ticks { last } else { Last::of(&self.sums.recent(ticks - 1)) }
    }

    /// [`MetricsObserver::observe_closely`] of several lanes, in line: a call would take them out of their registers.
    #[inline(always)]
    fn observe_side_by_side(&mut self, signals: Signals<L>) {
        let s = &signals;
        let Some(live) = &mut self.live else { return };
        let (bound_m, bound_n) = (L::splat(DIVERGED_M), L::splat(DIVERGED_N));
        let sound = s.master_position_m.abs().le(bound_m)
            & s.slave_position_m.abs().le(bound_m)
            & s.measured_force_n.abs().le(bound_n);
        let following = s.mode.lt(L::splat(0.5));
        let running = live.running();
        let diverging = running & !sound;
        let running = running & sound;
        if diverging.any() {
            let (tick, last) = self.last_close;
            let before = if tick + 1 >= s.tick { last } else { Last::of(&self.sums.recent(s.tick - 1)) };
            for index in (0..L::WIDTH).filter(|&index| diverging.lane(index)) {
                let history = &mut self.histories[index];
                live.store(index, history, s.tick.saturating_sub(1));
                live.end(index);
                history.diverged_at = Some(s.tick);
                history.last_sound = Some(before.lane(index));
                self.running -= 1;
            }
        }
        let sample = sample(s);
        let last = Last::of(&sample);
        if s.tick == 0 {
            self.first = last;
        }
        self.last_close = (s.tick, last);
        self.sums.push(s.tick, sample.only(running, following));

        let now = L::splat(s.tick as f64);
        let force_step_n = (s.commanded_force_n - self.last_commanded_n).abs();
        let asks = running & live.asks(now, s, !following | s.ruptured | s.alarm);
        if asks.any() {
            for index in (0..L::WIDTH).filter(|&index| asks.lane(index)) {
                let history = &mut self.histories[index];
                live.store(index, history, s.tick.saturating_sub(1));
                history.observe(&s.lane(index), force_step_n.lane(index), &self.grid);
            }
        }
        live.follow(now, s, force_step_n);
        if asks.any() {
            for index in (0..L::WIDTH).filter(|&index| asks.lane(index)) {
                live.load(index, &self.histories[index], s.tick);
            }
        }
        self.is_watching = live.any_open();
    }

    /// Where a lane has diverged.
    #[inline(always)]
    fn ended(&self) -> L::Mask {
        match &self.live {
            Some(live) => !live.running(),
            None => L::Mask::splat(false),
        }
    }

    /// Adds a tick of several lanes to the sums, where nothing goes on but that some may have diverged.
    #[inline(always)]
    fn push_side_by_side(&mut self, s: &Signals<L>) {
        let sample = match &self.live {
            Some(live) if self.running < L::WIDTH => sample(s).only(live.running(), L::Mask::splat(true)),
            _ => sample(s),
        };
        self.sums.push(s.tick, sample);
    }

    /// A tick at which something happens or is still happening, and the first.
    #[cold]
    #[inline]
    fn observe_closely(&mut self, s: Signals<L>) {
        let (bound_m, bound_n) = (L::splat(DIVERGED_M), L::splat(DIVERGED_N));
        let sound = s.master_position_m.abs().le(bound_m)
            & s.slave_position_m.abs().le(bound_m)
            & s.measured_force_n.abs().le(bound_n);
        let following = s.mode.lt(L::splat(0.5));
        let sample = sample(&s);
        let (before, now) = (self.last(s.tick), Last::of(&sample));
        if s.tick == 0 {
            self.first = now;
        }
        self.last_close = (s.tick, now);
        self.sums.push(s.tick, sample.only(sound, following));
        let eventful = !(sound & following) | s.ruptured | s.alarm;
        self.is_watching = false;
        for index in 0..L::WIDTH {
            let history = &mut self.histories[index];
            if history.diverged_at.is_some() {
                continue;
            }
            if !sound.lane(index) {
                history.diverged_at = Some(s.tick);
                history.last_sound = Some(before.lane(index));
                self.running -= 1;
                continue;
            }
            if eventful.lane(index) || history.has_open_window() {
                let force_step = (s.commanded_force_n - self.last_commanded_n).abs().lane(index);
                history.observe(&s.lane(index), force_step, &self.grid);
            }
            self.is_watching |= history.has_open_window();
        }
    }
}

impl<L: Lane> Observer<L> for MetricsObserver<L> {
    #[inline(always)]
    fn is_common() -> bool {
        true
    }

    #[inline(always)]
    fn observe(&mut self, s: &Signals<L>) {
        // One way for the ticks that only add to the sums, which most are, and another, out of line, for all others. The
        // strain is below 1 only in teleoperation and far from divergence; what is beyond is told apart out of line.
        let strain = (s.master_position_m.abs() + s.slave_position_m.abs()) * L::splat(1.0 / DIVERGED_M)
            + (s.measured_force_n.abs() * L::splat(1.0 / DIVERGED_N) + s.mode);
        let is_quiet = !(self.is_watching | s.ruptured.any() | s.alarm.any());
        if L::WIDTH > 1 {
            let quiet = strain.lt(L::splat(1.0));
            let ended = if self.running < L::WIDTH { self.ended() } else { L::Mask::splat(false) };
            if is_quiet && (quiet | ended).all() {
                self.push_side_by_side(s);
            } else {
                self.observe_side_by_side(seen(s));
            }
        } else if is_quiet && strain.lt(L::splat(1.0)).all() {
            self.sums.push(s.tick, sample(s));
        } else {
            self.observe_closely(seen(s));
        }
        self.last_commanded_n = s.commanded_force_n;
        self.ticks = s.tick + 1;
    }

    #[inline(always)]
    fn is_done(&self) -> bool {
        self.running == 0
    }
}
