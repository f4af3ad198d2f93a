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
        let following = ticks - augmented - reengaging;
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
            tracking_rmse_m: mean(self.sums.squared_tracking_error, following as f64).map(f64::sqrt),
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
}

impl<L: Lane> Sums<L> {
    /// Adds a tick of lanes that all run and follow the hand, as they nearly always do.
    #[inline(always)]
    fn add(&mut self, s: &Signals<L>) {
        let error = s.slave_position_m - s.slave_reference_m;
        let operator_power = s.operator_force_n * s.master_velocity_m_per_s;
        let tissue_power = s.tissue_force_n * s.slave_velocity_m_per_s;
        self.absolute_residual = self.absolute_residual + s.residual_n.abs();
        self.squared_tracking_error = self.squared_tracking_error + error * error;
        self.operator_power = self.operator_power + operator_power;
        self.tissue_power = self.tissue_power + tissue_power;
        self.last_operator_power = operator_power;
        self.last_tissue_power = tissue_power;
        self.last_slave = s.slave_position_m;
        self.last_reference = s.slave_reference_m;
        self.least_force = s.tissue_force_n.min(self.least_force);
        self.greatest_force = s.tissue_force_n.max(self.greatest_force);
    }

    /// Adds a tick to the lanes that are `running`, and to the tracking error of those that are `following` the hand.
    fn add_where(&mut self, s: &Signals<L>, running: L::Mask, following: L::Mask) {
        let before = *self;
        self.add(s);
        let keep = |new: &mut L, old: L| *new = L::select(running, *new, old);
        keep(&mut self.absolute_residual, before.absolute_residual);
        keep(&mut self.operator_power, before.operator_power);
        keep(&mut self.tissue_power, before.tissue_power);
        keep(&mut self.last_operator_power, before.last_operator_power);
        keep(&mut self.last_tissue_power, before.last_tissue_power);
        keep(&mut self.last_slave, before.last_slave);
        keep(&mut self.last_reference, before.last_reference);
        keep(&mut self.least_force, before.least_force);
        keep(&mut self.greatest_force, before.greatest_force);
        let new = self.squared_tracking_error;
        self.squared_tracking_error = L::select(running & following, new, before.squared_tracking_error);
    }
}

impl<L: Lane> Observer<L> for MetricsObserver<L> {
    #[inline(always)]
    fn observe(&mut self, s: &Signals<L>) {
        let bound = L::splat(DIVERGED_M);
        let sound = s.master_position_m.abs().le(bound) & s.slave_position_m.abs().le(bound);
        let following = s.mode.lt(L::splat(0.5));
        if self.ticks == 0 {
            self.sums.first_operator_power = s.operator_force_n * s.master_velocity_m_per_s;
            self.sums.first_tissue_power = s.tissue_force_n * s.slave_velocity_m_per_s;
        }
        if (sound & following).all() {
            self.sums.add(s);
        } else {
            self.sums.add_where(s, sound, following);
        }
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
