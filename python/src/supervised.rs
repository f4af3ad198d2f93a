//! Runs whose supervisor is an agent, for the Gymnasium environment.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use pyo3::prelude::*;
use pyo3::types::PyDict;
use trocar_base::parallel::map;
use trocar_engine::engine::UserDefinedParts;
use trocar_engine::teleoperation::{Architecture, ArrivedAtMaster, AtMaster, AtSlave, MasterSample};
use trocar_studies::run::{RunError, SteppedRun};

use crate::error;
use crate::run::{Run, hand_over};
use crate::scenario::Scenario;

/// What the agent commands: whether the slave holds its position, and the factor of the force for the hand.
#[derive(Debug, Clone, Copy)]
struct Command {
    holds: bool,
    force_scale: f64,
}

/// The architecture in the loop: position forward and force back, as commanded.
struct Commanded {
    command: Arc<Mutex<Command>>,
    position_scale: f64,
    /// Largest change of the target per tick after a hold, in m.
    step_m: f64,
    /// Target of a slave that holds or catches up, in m.
    target_m: Option<f64>,
    is_held: bool,
}

impl Architecture<f64> for Commanded {
    fn slave_target(&mut self, arrived: &MasterSample<f64>, slave: &AtSlave<f64>) -> f64 {
        let hand_m = self.position_scale * arrived.position_m;
        let holds = locked(&self.command).holds;
        if holds {
            self.target_m = self.target_m.filter(|_| self.is_held).or(Some(slave.position_m));
        } else if let Some(target_m) = self.target_m {
            let next_m = target_m + (hand_m - target_m).clamp(-self.step_m, self.step_m);
            self.target_m = ((hand_m - next_m).abs() > self.step_m).then_some(next_m);
        }
        self.is_held = holds;
        self.target_m.unwrap_or(hand_m)
    }

    fn master_force(&mut self, arrived: &ArrivedAtMaster<f64>, _: &AtMaster<f64>) -> f64 {
        locked(&self.command).force_scale * arrived.force_n
    }
}

/// A run that an agent supervises.
#[pyclass(frozen, module = "trocar._core")]
pub(crate) struct SupervisedRun {
    command: Arc<Mutex<Command>>,
    /// `None` after an error, and after the result was taken.
    run: Mutex<Option<Box<SteppedRun>>>,
}

impl SupervisedRun {
    /// Runs ticks with a command, up to the end of the run. Returns true if more ticks follow, and the largest decision
    /// of the detector.
    fn advanced(&self, command: Command, ticks: u64) -> Result<(bool, f64), Ended> {
        *locked(&self.command) = command;
        let mut kept = locked(&self.run);
        let run = kept.as_mut().ok_or(Ended::Before)?;
        let mut decision = 0.0_f64;
        for _ in 0..ticks {
            let outcome = run.step(None);
            decision = decision.max(run.trace().decision.last().copied().unwrap_or(0.0));
            match outcome {
                Ok(true) => {}
                Ok(false) => return Ok((false, decision)),
                Err(error) => {
                    *kept = None;
                    return Err(Ended::By(Box::new(error)));
                }
            }
        }
        Ok((true, decision))
    }
}

/// Why a run cannot be advanced.
enum Ended {
    Before,
    By(Box<RunError>),
}

impl Ended {
    fn raised(self, py: Python<'_>) -> PyErr {
        match self {
            Self::Before => error::value("the run has ended"),
            Self::By(error) => error::run(py, &error),
        }
    }
}

#[pymethods]
impl SupervisedRun {
    /// A run without augmentation, whose slave catches up with the hand at a speed in m/s after a hold.
    #[new]
    fn new(py: Python<'_>, scenario: &Scenario, catch_up_m_per_s: f64) -> PyResult<Self> {
        let scenario = scenario.scenario.clone();
        let command = Arc::new(Mutex::new(Command { holds: false, force_scale: 1.0 }));
        let commanded = Commanded {
            command: command.clone(),
            position_scale: scenario.link.machines.position_scale,
            step_m: catch_up_m_per_s * scenario.grid.tick_s(),
            target_m: None,
            is_held: false,
        };
        let run = SteppedRun::new(scenario, UserDefinedParts::default().architecture(commanded))
            .map_err(|error| error::run(py, &error))?;
        Ok(Self { command, run: Mutex::new(Some(Box::new(run))) })
    }

    /// Runs ticks with a command, up to the end of the run. Returns true if more ticks follow, and the largest decision
    /// of the detector.
    fn advance(&self, py: Python<'_>, holds: bool, force_scale: f64, ticks: u64) -> PyResult<(bool, f64)> {
        self.advanced(Command { holds, force_scale }, ticks).map_err(|ended| ended.raised(py))
    }

    /// The latest values of the measured force (N), the residual (N), the positions of master and slave (m) and their
    /// velocities (m/s).
    fn observed(&self) -> PyResult<[f64; 6]> {
        let run = locked(&self.run);
        let trace = run.as_ref().ok_or_else(|| error::value("the run has ended"))?.trace();
        let signals = [
            &trace.measured_force_n,
            &trace.residual_n,
            &trace.master_position_m,
            &trace.slave_position_m,
            &trace.master_velocity_m_per_s,
            &trace.slave_velocity_m_per_s,
        ];
        Ok(signals.map(|signal| signal.last().copied().unwrap_or(0.0)))
    }

    /// Ends the run. Returns it and the columns of its trace so far.
    fn conclude<'py>(&self, py: Python<'py>) -> PyResult<(Run, Bound<'py, PyDict>)> {
        let run = locked(&self.run).take().ok_or_else(|| error::value("the run has ended"))?;
        hand_over(py, run.conclude())
    }
}

/// Advances several runs side by side, in threads, each with the arguments of its [`SupervisedRun::advance`].
#[pyfunction]
pub(crate) fn advance_all(
    py: Python<'_>,
    runs: Vec<(PyRef<'_, SupervisedRun>, bool, f64, u64)>,
) -> PyResult<Vec<(bool, f64)>> {
    let all: Vec<(&SupervisedRun, Command, u64)> = runs
        .iter()
        .map(|(run, holds, force_scale, ticks)| (&**run, Command { holds: *holds, force_scale: *force_scale }, *ticks))
        .collect();
    let outcomes = py.detach(|| {
        map(all.len(), |at| {
            let (run, command, ticks) = all[at];
            run.advanced(command, ticks)
        })
    });
    outcomes.into_iter().map(|outcome| outcome.map_err(|ended| ended.raised(py))).collect()
}

fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
