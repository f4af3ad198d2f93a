use std::ops::ControlFlow;

use super::RunError;
use trocar_base::interrupt;
use trocar_engine::engine::{BuiltInOr, Observer, Signals, UserDefinedEngine, UserDefinedParts, Wiring};
use trocar_metrics::DIVERGED_M;
use trocar_scenario::Scenario;

/// A repeated run that rests from a tick on: hand and organs stay, the force sensor has no noise, and a replayed force
/// keeps its last value. Only the loop remains, with the link's losses and the arm's reflexes.
pub(super) struct AtRest {
    engine: UserDefinedEngine,
    tick: u64,
    desired_m: f64,
    pub(super) positions_m: [Vec<f64>; 2],
    pub(super) has_ended: bool,
}

struct Positions<'a>(&'a mut [Vec<f64>; 2]);

impl Observer<f64> for Positions<'_> {
    fn observe(&mut self, signals: &Signals<f64>) {
        let Self([slave, master]) = self;
        slave.push(signals.slave_position_m);
        master.push(signals.master_position_m);
    }

    fn is_done(&self) -> bool {
        // A comparison with NaN is false.
        !self.0.iter().all(|all| all.last().is_none_or(|position_m| position_m.abs() <= DIVERGED_M))
    }
}

impl AtRest {
    /// Logged delays repeat from tick `repeat` on.
    pub(super) fn new(scenario: &Scenario, rest: u64, repeat: u64, ticks: u64) -> Result<Self, RunError> {
        let mut scenario = scenario.clone();
        let end = scenario.grid.ticks();
        for schedule in [&mut scenario.forward_schedule, &mut scenario.backward_schedule] {
            *schedule = schedule.repeating(repeat, end, rest + ticks);
        }
        let mut engine = scenario.build_with(UserDefinedParts::default())?;
        let desired_m = engine.parts.begin();
        let positions_m = [vec![], vec![]];
        let mut run = Self { engine, tick: 0, desired_m, positions_m, has_ended: false };
        run.advance_to(rest, &mut ());
        run.rest();
        Ok(run)
    }

    fn rest(&mut self) {
        let parts = &mut self.engine.parts;
        if let BuiltInOr::BuiltIn(operator) = &mut parts.operator {
            operator.rest(self.tick);
        }
        if let BuiltInOr::BuiltIn(tissue) = &mut parts.tissue {
            tissue.stop_organs();
        }
        parts.sensor.silence();
    }

    pub(super) fn extend_to(&mut self, ticks: u64) {
        let end = self.tick + ticks.saturating_sub(self.positions_m[0].len() as u64);
        let mut positions_m = std::mem::take(&mut self.positions_m);
        self.advance_to(end, &mut Positions(&mut positions_m));
        self.positions_m = positions_m;
    }

    fn advance_to(&mut self, end: u64, observer: &mut impl Observer<f64>) {
        while self.tick < end && !self.has_ended {
            interrupt::check_at(self.tick);
            match self.engine.parts.tick(self.tick, self.desired_m, &mut self.engine.plants, observer) {
                ControlFlow::Continue(next_m) => (self.desired_m, self.tick) = (next_m, self.tick + 1),
                // The original run has completed, so a later failure is not its error.
                ControlFlow::Break(_) => self.has_ended = true,
            }
        }
    }
}
