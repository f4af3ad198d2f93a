//! From ticks to metrics.

use super::event::EventWindow;
use super::rupture::RuptureWindow;
use super::{Alarm, DIVERGED_M, Metrics, ModeTimes, Outcome};
use crate::augmentation::Mode;
use crate::engine::{Observer, Signals};
use crate::lane::{Lane, Mask};
use crate::time::TickGrid;

/// Most ruptures, events and alarms that are kept one by one; later ones are counted.
const MOST_KEPT: usize = 4096;

/// Sums over every tick of a lane's run, in lanes.
#[derive(Debug, Clone, Copy)]
struct Sums<L> {
    absolute_residual: L,
    squared_tracking_error: L,
    teleoperation_ticks: L,
    operator_power: L,
    tissue_power: L,
    first_operator_power: L,
    first_tissue_power: L,
    last_operator_power: L,
    last_tissue_power: L,
    last_slave: L,
    last_reference: L,
    least_force: L,
    greatest_force: L,
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
}

impl History {
    fn new(ruptures: usize) -> Self {
        Self {
            ruptures: Vec::with_capacity(ruptures.min(MOST_KEPT)),
            first_open: 0,
            events: Vec::with_capacity(ruptures.clamp(16, MOST_KEPT)),
            event_goes_on: false,
            alarms: Vec::with_capacity(MOST_KEPT),
            false_alarms: 0,
            ignored_alarms: 0,
            mode: Mode::Teleoperation.code(),
            mode_ticks: [0; 3],
            mode_switches: 0,
            step_excess_n: 0.0,
            diverged_at: None,
        }
    }

    fn has_open_window(&self) -> bool {
        self.first_open < self.ruptures.len() || self.event_goes_on
    }

    /// A tick at which something happens or is still happening.
    fn observe(&mut self, s: &Signals<f64>, force_step_n: f64, grid: &TickGrid) {
        while self.ruptures.get(self.first_open).is_some_and(|rupture| !rupture.contains(s.tick)) {
            self.first_open += 1;
        }
        let open = &mut self.ruptures[self.first_open..];
        for rupture in open.iter_mut() {
            rupture.observe(s);
        }
        if s.alarm_taken {
            let matched = open.iter_mut().any(|rupture| rupture.claim(s.tick));
            self.false_alarms += u64::from(!matched);
            if self.alarms.len() < MOST_KEPT {
                self.alarms.push(Alarm { time_s: grid.time_s(s.tick), matched });
            }
        } else if s.alarm {
            self.ignored_alarms += 1;
        }
        if s.ruptured && self.ruptures.len() < MOST_KEPT {
            self.ruptures.push(RuptureWindow::open(s, grid));
        }
        self.mode_ticks[s.mode as usize] += 1;
        self.observe_event(s, force_step_n, grid);
    }

    fn observe_event(&mut self, s: &Signals<f64>, step: f64, grid: &TickGrid) {
        if self.event_goes_on || s.mode != self.mode {
            self.step_excess_n = self.step_excess_n.max(step - s.allowed_force_step_n);
        }
        if s.mode == Mode::Augmented.code() && self.mode == Mode::Teleoperation.code() && self.events.len() < MOST_KEPT
        {
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
    histories: Vec<History>,
    /// Lanes that have not diverged.
    running: usize,
    /// Lanes with something going on.
    open_histories: usize,
    last_commanded_n: L,
}

impl<L: Lane> MetricsObserver<L> {
    /// An observer with room for an expected number of ruptures; more are taken, at the price of an allocation.
    #[must_use]
    pub fn new(grid: TickGrid, expected_ruptures: usize) -> Self {
        let zero = L::zero();
        Self {
            grid,
            ticks: 0,
            sums: Sums {
                absolute_residual: zero,
                squared_tracking_error: zero,
                teleoperation_ticks: zero,
                operator_power: zero,
                tissue_power: zero,
                first_operator_power: zero,
                first_tissue_power: zero,
                last_operator_power: zero,
                last_tissue_power: zero,
                last_slave: zero,
                last_reference: zero,
                least_force: L::splat(f64::INFINITY),
                greatest_force: L::splat(f64::NEG_INFINITY),
            },
            histories: (0..L::WIDTH).map(|_| History::new(expected_ruptures)).collect(),
            running: L::WIDTH,
            open_histories: 0,
            last_commanded_n: zero,
        }
    }

    /// The metrics of lane `index`.
    #[must_use]
    pub fn metrics(&self, index: usize) -> Metrics {
        let history = &self.histories[index];
        let ticks = history.diverged_at.unwrap_or(self.ticks);
        let tick_s = self.grid.tick_s();
        let ran = ticks > 0;
        let mean = |sum: L, count: f64| (count > 0.0).then(|| sum.lane(index) / count);
        let energy = |sum: L, first: L, last: L| {
            ran.then(|| (sum.lane(index) - 0.5 * (first.lane(index) + last.lane(index))) * tick_s)
        };
        let slave_m = self.sums.last_slave.lane(index);
        let reference_m = self.sums.last_reference.lane(index);
        let events: Vec<_> = history.events.iter().map(|event| event.close(tick_s)).collect();
        let ruptures: Vec<_> = history.ruptures.iter().map(RuptureWindow::close).collect();
        let [_, augmented, reengaging] = history.mode_ticks;
        let peak = events.iter().filter_map(|event| event.peak_reengaging_speed_m_per_s).reduce(f64::max);
        Metrics {
            outcome: history
                .diverged_at
                .map_or(Outcome::Completed, |tick| Outcome::Diverged { time_s: self.grid.time_s(tick) }),
            ticks,
            missed_ruptures: ruptures.iter().filter(|rupture| rupture.detection_delay_s.is_none()).count() as u64,
            alarms: history.alarms.clone(),
            false_alarms: history.false_alarms,
            ignored_alarms: history.ignored_alarms,
            mean_absolute_residual_n: mean(self.sums.absolute_residual, ticks as f64),
            least_tissue_force_n: ran.then(|| self.sums.least_force.lane(index)),
            greatest_tissue_force_n: ran.then(|| self.sums.greatest_force.lane(index)),
            tracking_rmse_m: mean(self.sums.squared_tracking_error, self.sums.teleoperation_ticks.lane(index))
                .map(f64::sqrt),
            final_slave_position_m: ran.then_some(slave_m),
            final_tracking_error: (ran && reference_m != 0.0).then(|| (reference_m - slave_m) / reference_m),
            peak_reengaging_speed_m_per_s: peak,
            feedback_step_excess_n: history.step_excess_n,
            mode_times: ModeTimes {
                teleoperation_s: (ticks - augmented - reengaging) as f64 * tick_s,
                augmented_s: augmented as f64 * tick_s,
                reengaging_s: reengaging as f64 * tick_s,
            },
            mode_switches: history.mode_switches,
            operator_energy_j: energy(
                self.sums.operator_power,
                self.sums.first_operator_power,
                self.sums.last_operator_power,
            ),
            tissue_energy_j: energy(self.sums.tissue_power, self.sums.first_tissue_power, self.sums.last_tissue_power),
            ruptures,
            events,
        }
    }

    /// The lanes in which something happens or is still happening; seldom any.
    fn observe_histories(&mut self, s: &Signals<L>, sound: L::Mask, eventful: L::Mask) {
        self.open_histories = 0;
        for index in 0..L::WIDTH {
            let history = &mut self.histories[index];
            if history.diverged_at.is_some() {
                continue;
            }
            if !sound.lane(index) {
                history.diverged_at = Some(s.tick);
                self.running -= 1;
                continue;
            }
            if eventful.lane(index) || history.has_open_window() {
                let force_step = (s.commanded_force_n - self.last_commanded_n).abs().lane(index);
                history.observe(&s.lane(index), force_step, &self.grid);
            }
            self.open_histories += usize::from(history.has_open_window());
        }
    }

    /// Adds a tick to the sums of the lanes that are `running`, those in teleoperation to the tracking error's.
    #[inline(always)]
    fn add(&mut self, s: &Signals<L>, running: L::Mask, following: L::Mask) {
        let operator_power = s.operator_force_n * s.master_velocity_m_per_s;
        let tissue_power = s.tissue_force_n * s.slave_velocity_m_per_s;
        if self.ticks == 0 {
            self.sums.first_operator_power = operator_power;
            self.sums.first_tissue_power = tissue_power;
        }
        let before = self.sums;
        let error = s.slave_position_m - s.slave_reference_m;
        let sums = &mut self.sums;
        sums.absolute_residual = before.absolute_residual + s.residual_n.abs();
        sums.operator_power = before.operator_power + operator_power;
        sums.tissue_power = before.tissue_power + tissue_power;
        sums.last_operator_power = operator_power;
        sums.last_tissue_power = tissue_power;
        sums.last_slave = s.slave_position_m;
        sums.last_reference = s.slave_reference_m;
        sums.least_force = s.tissue_force_n.min(before.least_force);
        sums.greatest_force = s.tissue_force_n.max(before.greatest_force);
        sums.squared_tracking_error = before.squared_tracking_error + error * error;
        sums.teleoperation_ticks = before.teleoperation_ticks + L::splat(1.0);
        if !(running & following).all() {
            sums.keep(&before, running, following);
        }
    }
}

impl<L: Lane> Sums<L> {
    /// Takes back what was added to lanes that do not run, and the tracking of those that do not follow.
    fn keep(&mut self, before: &Self, running: L::Mask, following: L::Mask) {
        let new = *self;
        let keep = |new: L, old: L| L::select(running, new, old);
        let track = |new: L, old: L| L::select(running & following, new, old);
        *self = Self {
            absolute_residual: keep(new.absolute_residual, before.absolute_residual),
            squared_tracking_error: track(new.squared_tracking_error, before.squared_tracking_error),
            teleoperation_ticks: track(new.teleoperation_ticks, before.teleoperation_ticks),
            operator_power: keep(new.operator_power, before.operator_power),
            tissue_power: keep(new.tissue_power, before.tissue_power),
            first_operator_power: new.first_operator_power,
            first_tissue_power: new.first_tissue_power,
            last_operator_power: keep(new.last_operator_power, before.last_operator_power),
            last_tissue_power: keep(new.last_tissue_power, before.last_tissue_power),
            last_slave: keep(new.last_slave, before.last_slave),
            last_reference: keep(new.last_reference, before.last_reference),
            least_force: keep(new.least_force, before.least_force),
            greatest_force: keep(new.greatest_force, before.greatest_force),
        };
    }
}

impl<L: Lane> Observer<L> for MetricsObserver<L> {
    #[inline(always)]
    fn observe(&mut self, s: &Signals<L>) {
        let bound = L::splat(DIVERGED_M);
        let sound = s.master_position_m.abs().le(bound) & s.slave_position_m.abs().le(bound);
        let following = s.mode.lt(L::splat(0.5));
        self.add(s, sound, following);
        let eventful = !sound | !following | s.ruptured | s.alarm;
        if eventful.any() || self.open_histories > 0 {
            self.observe_histories(s, sound, eventful);
        }
        self.last_commanded_n = s.commanded_force_n;
        self.ticks += 1;
    }

    #[inline(always)]
    fn is_done(&self) -> bool {
        self.running == 0
    }
}
