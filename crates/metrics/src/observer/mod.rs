mod open_windows;

use self::open_windows::OpenWindows;
use super::event::{Beginning, EventWindow};
use super::intent::Pursuit;
use super::rupture::{Return, RuptureWindow};
use super::sums::{Sample, Sums};
use super::{Alarm, DIVERGED_M, HORIZON_S, Metrics, ModeTimes, Outcome};
use trocar_core::augmentation::Mode;
use trocar_core::lane::{Lane, Mask};
use trocar_core::time::TickGrid;
use trocar_engine::engine::{Observer, Signals};
use trocar_engine::operator::OperatorTraits;

/// Ruptures, events and alarms of a run that are recorded individually.
const MAX_RECORDED: usize = 4096;

/// A run diverges beyond this measured force, or at NaN: over a million times a needle's forces.
const DIVERGED_N: f64 = 1e9;

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

/// An event tick does not use the estimates: fewer values stay live.
#[inline(always)]
fn without_estimates<L: Lane>(s: &Signals<L>) -> Signals<L> {
    let zero = L::zero();
    let nothing = Signals { desired_position_m: zero, stiffness_n_per_m: zero, damping_n_s_per_m: zero, ..*s };
    Signals { distance: zero, decision: zero, ..nothing }
}

#[derive(Debug, Clone, Copy)]
struct Intent {
    gap_m: Option<f64>,
    horizon_ticks: u64,
    withdraws: bool,
}

/// Separate from the sums because they change rarely.
#[derive(Debug, Clone)]
struct History {
    ruptures: Vec<RuptureWindow>,
    first_open: usize,
    events: Vec<EventWindow>,
    is_event_open: bool,
    alarms: Vec<Alarm>,
    false_alarms: u64,
    ignored_alarms: u64,
    false_notices: u64,
    mode: Mode,
    mode_ticks: [u64; 3],
    mode_switches: u64,
    step_excess_n: f64,
    diverged_at: Option<u64>,
    last_valid: Option<Last<f64>>,
}

impl History {
    fn new(ruptures: usize) -> Self {
        Self {
            ruptures: Vec::with_capacity(ruptures.min(MAX_RECORDED)),
            first_open: 0,
            events: Vec::with_capacity(ruptures.clamp(16, MAX_RECORDED)),
            is_event_open: false,
            alarms: Vec::with_capacity(MAX_RECORDED),
            false_alarms: 0,
            ignored_alarms: 0,
            false_notices: 0,
            mode: Mode::Teleoperation,
            mode_ticks: [0; 3],
            mode_switches: 0,
            step_excess_n: 0.0,
            diverged_at: None,
            last_valid: None,
        }
    }

    fn has_open_window(&self) -> bool {
        self.first_open < self.ruptures.len() || self.is_event_open
    }

    #[inline(always)]
    fn observe(&mut self, s: &Signals<f64>, force_step_n: f64, grid: &TickGrid, intent: &Intent) {
        while self.ruptures.get(self.first_open).is_some_and(|rupture| !rupture.contains(s.tick)) {
            self.first_open += 1;
        }
        for rupture in &mut self.ruptures[self.first_open..] {
            rupture.observe(s, intent.gap_m);
        }
        // An alarm at the tick of a rupture is its detection.
        if s.ruptured && self.ruptures.len() < MAX_RECORDED {
            self.ruptures.push(RuptureWindow::open(s, *grid, intent.gap_m));
        }
        let mut is_false = true;
        if s.alarm_taken {
            // An alarm belongs to the latest rupture that can claim it.
            let matched = self.ruptures[self.first_open..].iter_mut().rev().any(|rupture| rupture.claim(s));
            self.false_alarms += u64::from(!matched);
            is_false = !matched;
            if self.alarms.len() < MAX_RECORDED {
                self.alarms.push(Alarm { time_s: grid.time_s(s.tick), matched });
            }
        } else if s.alarm {
            self.ignored_alarms += 1;
        }
        self.mode_ticks[s.mode.lane(0) as usize] += 1;
        self.observe_mode(s, force_step_n, is_false, intent);
        if s.noticed {
            self.attribute_notice(s.tick, intent);
        }
    }

    fn attribute_notice(&mut self, tick: u64, intent: &Intent) {
        let horizon_ticks = intent.horizon_ticks;
        let rupture = self.ruptures.last_mut().filter(|rupture| tick - rupture.tick <= horizon_ticks);
        let event = self.events.last_mut().filter(|event| tick - event.start <= horizon_ticks);
        self.false_notices += u64::from(rupture.is_none() && event.is_none() && !intent.withdraws);
        if let Some(rupture) = rupture {
            rupture.noticed_at.get_or_insert(tick);
        }
        if let Some(event) = event {
            event.noticed_at.get_or_insert(tick);
        }
    }

    #[inline(always)]
    fn observe_mode(&mut self, s: &Signals<f64>, step: f64, is_false: bool, intent: &Intent) {
        let mode = s.mode.lane(0);
        if self.is_event_open || mode != self.mode {
            self.step_excess_n = self.step_excess_n.max(step - s.allowed_force_step_n);
        }
        if mode == Mode::Augmented && self.mode == Mode::Teleoperation && self.events.len() < MAX_RECORDED {
            let first_rupture = if is_false { self.ruptures.len() } else { self.ruptures.len().saturating_sub(1) };
            self.events.push(EventWindow::open(s, step, Beginning { first_rupture, is_false, gap_m: intent.gap_m }));
            self.is_event_open = true;
        }
        if self.is_event_open {
            self.is_event_open = self.events.last_mut().is_some_and(|event| event.observe(s, step));
            if let Some(event) = self.events.last_mut().filter(|_| !self.is_event_open) {
                event.excess_m = intent.gap_m.zip(event.beginning.gap_m).map(|(gap_m, before_m)| gap_m - before_m);
                let released_m = event.released_m;
                for rupture in self.ruptures.iter_mut().skip(event.beginning.first_rupture) {
                    rupture.returned = Some(Return { tick: s.tick, slave_m: s.slave_position_m, released_m });
                }
            }
        }
        self.mode_switches += u64::from(mode != self.mode);
        self.mode = mode;
    }
}

fn intent_of<L: Lane>(pursuit: &Pursuit<L>, lane: usize) -> Intent {
    Intent { gap_m: pursuit.gap_m(lane), horizon_ticks: pursuit.horizon_ticks(), withdraws: pursuit.withdraws(lane) }
}

#[cold]
#[inline(never)]
fn update_horizon<L: Lane>(
    pursuit: &mut Pursuit<L>,
    history: &mut History,
    (lane, tick, ruptured): (usize, u64, bool),
) {
    if let Some((rupture, aftermath)) = pursuit.close(lane, tick, ruptured) {
        history.ruptures[rupture].aftermath = Some(aftermath);
    }
    let newest = history.ruptures.len().wrapping_sub(1);
    if ruptured && history.ruptures.last().is_some_and(|rupture| rupture.tick == tick) {
        pursuit.open(lane, tick, newest);
    }
}

#[derive(Debug, Clone)]
pub struct MetricsObserver<L: Lane> {
    grid: TickGrid,
    ticks: u64,
    sums: Sums<L>,
    first: Last<L>,
    /// The sums hold the signals of the last event tick masked.
    last_event_tick: (u64, Last<L>),
    histories: Vec<History>,
    /// `None` for one lane.
    windows: Option<Box<OpenWindows<L>>>,
    running: usize,
    /// At the first tick, and while a window is open.
    next_is_event: bool,
    last_commanded_n: L,
    pursuit: Pursuit<L>,
    is_horizon_due: bool,
}

impl<L: Lane> MetricsObserver<L> {
    pub fn new(grid: TickGrid, expected_ruptures: usize) -> Self {
        let zero = L::zero();
        let nothing = Last { slave_m: zero, reference_m: zero, operator_power_w: zero, tissue_power_w: zero };
        Self {
            grid,
            ticks: 0,
            sums: Sums::new(),
            first: nothing,
            last_event_tick: (0, nothing),
            histories: (0..L::WIDTH).map(|_| History::new(expected_ruptures)).collect(),
            windows: (L::WIDTH > 1).then(|| Box::new(OpenWindows::new())),
            running: L::WIDTH,
            next_is_event: true,
            last_commanded_n: zero,
            pursuit: Pursuit::new(grid.tick_s(), HORIZON_S),
            is_horizon_due: false,
        }
    }

    pub fn of_operators(mut self, traits: impl Fn(usize) -> OperatorTraits) -> Self {
        self.pursuit.set_operators(traits);
        self
    }

    pub fn metrics(&self, index: usize) -> Metrics {
        let mut history = std::borrow::Cow::Borrowed(&self.histories[index]);
        if let Some(windows) = self.windows.as_ref().filter(|_| history.diverged_at.is_none()) {
            windows.store(index, history.to_mut(), self.ticks.saturating_sub(1));
        }
        let ticks = history.diverged_at.unwrap_or(self.ticks);
        let tick_s = self.grid.tick_s();
        let ran = ticks > 0;
        let mean = |sum: f64, count: f64| (count > 0.0).then(|| sum / count);
        let totals = self.sums.totals_of(index, self.ticks);
        let (first, last) = (self.first.lane(index), history.last_valid.unwrap_or(self.last(self.ticks).lane(index)));
        let energy = |sum: f64, first: f64, last: f64| ran.then_some((sum - 0.5 * (first + last)) * tick_s);
        let (slave_m, reference_m) = (last.slave_m, last.reference_m);
        let notices = self.pursuit.operator(index).notices;
        let events: Vec<_> = history.events.iter().map(|event| event.close(&self.grid, notices)).collect();
        let ruptures: Vec<_> = history.ruptures.iter().map(|rupture| rupture.close(notices)).collect();
        let final_excess_m = self.pursuit.final_gap_m(index).filter(|_| history.diverged_at.is_none());
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
            final_excess_m,
            false_notices: notices.then_some(history.false_notices),
            undisturbed_s: self
                .pursuit
                .undisturbed_ticks(index)
                .filter(|_| history.diverged_at.is_none())
                .map(|ticks| self.grid.time_s(ticks)),
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
            ports: None,
        }
    }

    fn last(&self, ticks: u64) -> Last<L> {
        let (tick, last) = self.last_event_tick;
        if tick + 1 >= ticks { last } else { Last::of(&self.sums.recent(ticks - 1)) }
    }

    /// Inlined because a call would spill the lanes' registers.
    #[inline(always)]
    fn observe_side_by_side(&mut self, signals: Signals<L>) {
        let s = &signals;
        let Some(windows) = &mut self.windows else { return };
        let (bound_m, bound_n) = (L::splat(DIVERGED_M), L::splat(DIVERGED_N));
        let valid = s.master_position_m.abs().le(bound_m)
            & s.slave_position_m.abs().le(bound_m)
            & s.measured_force_n.abs().le(bound_n);
        let following = s.mode.is_teleoperation();
        let running = windows.running();
        let diverging = running & !valid;
        let running = running & valid;
        if diverging.any() {
            let (tick, last) = self.last_event_tick;
            let before = if tick + 1 >= s.tick { last } else { Last::of(&self.sums.recent(s.tick - 1)) };
            for index in (0..L::WIDTH).filter(|&index| diverging.lane(index)) {
                let history = &mut self.histories[index];
                windows.store(index, history, s.tick.saturating_sub(1));
                windows.end(index);
                history.diverged_at = Some(s.tick);
                history.last_valid = Some(before.lane(index));
                self.running -= 1;
                self.pursuit.abandon(index);
            }
        }
        let sample = sample(s);
        let last = Last::of(&sample);
        if s.tick == 0 {
            self.first = last;
        }
        self.last_event_tick = (s.tick, last);
        self.sums.push(s.tick, sample.only(running, following));

        let now = L::splat(s.tick as f64);
        let force_step_n = (s.commanded_force_n - self.last_commanded_n).abs();
        let needs_history = running & windows.needs_history(now, s, !following | s.ruptured | s.alarm | s.noticed);
        if needs_history.any() {
            for index in (0..L::WIDTH).filter(|&index| needs_history.lane(index)) {
                let history = &mut self.histories[index];
                windows.store(index, history, s.tick.saturating_sub(1));
                let intent = intent_of(&self.pursuit, index);
                history.observe(&s.lane(index), force_step_n.lane(index), &self.grid, &intent);
            }
        }
        windows.follow(now, s, force_step_n);
        if needs_history.any() {
            for index in (0..L::WIDTH).filter(|&index| needs_history.lane(index)) {
                windows.load(index, &self.histories[index], s.tick);
            }
        }
        self.next_is_event = windows.any_open();
        self.update_horizons(s, running);
    }

    #[inline(always)]
    fn update_horizons(&mut self, s: &Signals<L>, running: L::Mask) {
        if (s.ruptured | s.alarm_taken).any() {
            self.pursuit.disturb(s.ruptured | s.alarm_taken, s.tick);
        }
        if self.is_horizon_due | s.ruptured.any() {
            for lane in (0..L::WIDTH).filter(|&lane| running.lane(lane)) {
                update_horizon(&mut self.pursuit, &mut self.histories[lane], (lane, s.tick, s.ruptured.lane(lane)));
            }
        }
    }

    #[inline(always)]
    fn ended(&self) -> L::Mask {
        match &self.windows {
            Some(windows) => !windows.running(),
            None => L::Mask::splat(false),
        }
    }

    #[inline(always)]
    fn push_side_by_side(&mut self, s: &Signals<L>) {
        let sample = match &self.windows {
            Some(windows) if self.running < L::WIDTH => sample(s).only(windows.running(), L::Mask::splat(true)),
            _ => sample(s),
        };
        self.sums.push(s.tick, sample);
    }

    #[cold]
    #[inline]
    fn observe_event(&mut self, s: Signals<L>) {
        let (bound_m, bound_n) = (L::splat(DIVERGED_M), L::splat(DIVERGED_N));
        let valid = s.master_position_m.abs().le(bound_m)
            & s.slave_position_m.abs().le(bound_m)
            & s.measured_force_n.abs().le(bound_n);
        let following = s.mode.is_teleoperation();
        let sample = sample(&s);
        let (before, now) = (self.last(s.tick), Last::of(&sample));
        if s.tick == 0 {
            self.first = now;
        }
        self.last_event_tick = (s.tick, now);
        self.sums.push(s.tick, sample.only(valid, following));
        let eventful = !(valid & following) | s.ruptured | s.alarm | s.noticed;
        self.next_is_event = false;
        for index in 0..L::WIDTH {
            let history = &mut self.histories[index];
            if history.diverged_at.is_some() {
                continue;
            }
            if !valid.lane(index) {
                history.diverged_at = Some(s.tick);
                history.last_valid = Some(before.lane(index));
                self.running -= 1;
                self.pursuit.abandon(index);
                continue;
            }
            if eventful.lane(index) || history.has_open_window() {
                let force_step = (s.commanded_force_n - self.last_commanded_n).abs().lane(index);
                history.observe(&s.lane(index), force_step, &self.grid, &intent_of(&self.pursuit, index));
            }
            self.next_is_event |= history.has_open_window();
        }
        self.update_horizons(&s, valid);
    }
}

impl<L: Lane> Observer<L> for MetricsObserver<L> {
    #[inline(always)]
    fn observe(&mut self, s: &Signals<L>) {
        // Fast path: most ticks only add to the sums. `bound` is below 1 only far from divergence; the general path
        // checks exactly.
        let bound = (s.master_position_m.abs() + s.slave_position_m.abs()) * L::splat(1.0 / DIVERGED_M)
            + s.measured_force_n.abs() * L::splat(1.0 / DIVERGED_N);
        let quiet = s.mode.is_teleoperation() & bound.lt(L::splat(1.0));
        self.is_horizon_due = self.pursuit.follow(s.tick, s.intended_position_m, s.slave_position_m);
        let is_quiet = !(self.next_is_event | self.is_horizon_due | (s.ruptured | s.alarm | s.noticed).any());
        if L::WIDTH > 1 {
            let ended = if self.running < L::WIDTH { self.ended() } else { L::Mask::splat(false) };
            if is_quiet && (quiet | ended).all() {
                self.push_side_by_side(s);
            } else {
                self.observe_side_by_side(without_estimates(s));
            }
        } else if is_quiet && quiet.all() {
            self.sums.push(s.tick, sample(s));
        } else {
            self.observe_event(without_estimates(s));
        }
        self.last_commanded_n = s.commanded_force_n;
        self.ticks = s.tick + 1;
    }

    #[inline(always)]
    fn is_done(&self) -> bool {
        self.running == 0
    }
}
