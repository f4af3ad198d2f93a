//! The linear loop of a scenario at the worst stiffness of its tissue.

use super::machines::Machines;
use super::{ClosedLoop, Limit, LinearLoop, Parameter, Search, StabilityError, TissueRange, largest_stable};
use trocar_engine::channel::Schedule;
use trocar_engine::plant::ActuatorLimits;
use trocar_engine::teleoperation::{LinkSettings, PassivitySettings};
use trocar_scenario::Scenario;

/// Number of stiffnesses at which the loop is analysed, and of divisions of the interval around the worst.
const STIFFNESSES: u32 = 12;
const REFINEMENTS: usize = 30;

/// Number of stiffnesses from first contact on, and the ratio of the largest to the smallest.
const POINTS: usize = 25;
const SPAN: f64 = 1e3;

/// Smallest upper end of that range.
const MIN_STIFFNESS_N_PER_M: f64 = 1e-3;

impl LinearLoop {
    /// The loop of a scenario at the worst stiffness of a range: the stiffest unstable one, otherwise the one with the
    /// smallest gain margin. Of varying delays from a file it uses the shortest, because jitter is added to the delay
    /// ([`VaryingDelays`](super::VaryingDelays)).
    ///
    /// # Errors
    /// [`StabilityError`] if the loop cannot be analysed.
    pub fn of(scenario: &Scenario, tissue: TissueRange) -> Result<Self, StabilityError> {
        let delay_s = |schedule: &Schedule, delay_s: f64| {
            schedule.ages().map_or(delay_s, |(shortest, _)| scenario.grid.time_s(shortest))
        };
        let stiffest = Self {
            tissue,
            tick_s: scenario.grid.tick_s(),
            timing: scenario.timing,
            master: scenario.master,
            master_model: scenario.master_model.clone(),
            arm: scenario.arm,
            slave: scenario.slave.clone(),
            actuators: ActuatorLimits {
                master_lag_s: scenario.actuators.master_lag_s,
                slave_lag_s: scenario.actuators.slave_lag_s,
                ..ActuatorLimits::NONE
            },
            link: LinkSettings { passivity: PassivitySettings::DEFAULT, ..scenario.link },
            force_bandwidth_hz: scenario.sensor.force_bandwidth_hz,
            forward_delay_s: delay_s(&scenario.forward_schedule, scenario.delays.forward_delay_s),
            backward_delay_s: delay_s(&scenario.backward_schedule, scenario.delays.backward_delay_s),
            stiffness_n_per_m: tissue.stiffness_n_per_m.1,
            damping_n_s_per_m: tissue.damping_n_s_per_m,
        };
        if tissue.is_single() { Ok(stiffest) } else { stiffest.at_worst() }
    }

    fn at_worst(self) -> Result<Self, StabilityError> {
        let (low, high) = self.tissue.stiffness_n_per_m;
        let machines = Machines::new(&self)?;
        let closed = ClosedLoop::of(&machines, &self, None)?;
        let at = |stiffness_n_per_m: f64| {
            let other = Self { stiffness_n_per_m, ..self.clone() };
            ClosedLoop::of(&machines, &other, Some(&closed))
        };
        let stiffness = |k: u32| low + f64::from(k) / f64::from(STIFFNESSES) * (high - low);
        let mut worst = Worst { stiffness_n_per_m: high, change: closed.destabilising_change(f64::INFINITY)? };
        let mut interval = None;
        for k in (0..STIFFNESSES).rev() {
            // An unstable loop cannot become worse.
            if worst.change == 0.0 {
                break;
            }
            if worst.replace_by(stiffness(k), &at(stiffness(k))?)? && k > 0 {
                interval = Some((stiffness(k - 1), stiffness(k + 1).min(high)));
            }
        }
        if let Some((mut from, mut to)) = interval {
            for _ in 0..REFINEMENTS {
                let (a, b) = (from + (to - from) / 3.0, to - (to - from) / 3.0);
                let bound = f64::INFINITY;
                if at(a)?.destabilising_change(bound)? < at(b)?.destabilising_change(bound)? {
                    to = b
                } else {
                    from = a
                }
            }
            let middle = 0.5 * (from + to);
            worst.replace_by(middle, &at(middle)?)?;
        }
        Ok(Self { stiffness_n_per_m: worst.stiffness_n_per_m, ..self })
    }

    /// True if the loop is stable at every stiffness from 0 (no contact) to the stiffest of its tissue.
    ///
    /// # Errors
    /// [`StabilityError`] if the loop cannot be analysed.
    pub fn is_stable(&self) -> Result<bool, StabilityError> {
        let (_, stiffest) = self.tissue.stiffness_n_per_m;
        let high = stiffest.max(MIN_STIFFNESS_N_PER_M);
        let search = Search { low: high / SPAN, high, points: POINTS, tolerance: 1e-9 };
        let Limit { stable, .. } = largest_stable(self, Parameter::Stiffness, search)?;
        Ok(stable.iter().any(|&(from, to)| from <= 0.0 && stiffest <= to))
    }
}

struct Worst {
    stiffness_n_per_m: f64,
    /// See [`ClosedLoop::destabilising_change`].
    change: f64,
}

impl Worst {
    fn replace_by(&mut self, stiffness_n_per_m: f64, closed: &ClosedLoop) -> Result<bool, StabilityError> {
        let change = closed.destabilising_change(self.change)?;
        let is_worse = change < self.change;
        if is_worse {
            *self = Self { stiffness_n_per_m, change };
        }
        Ok(is_worse)
    }
}
