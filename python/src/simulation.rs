//! A simulation that is stepped tick by tick.

use std::sync::{Mutex, MutexGuard, PoisonError};

use pyo3::prelude::*;
use pyo3::types::PyDict;
use trocar_sim::engine::{COLUMNS, ColumnValues};
use trocar_sim::run::SteppedRun;

use crate::error;
use crate::own::{Failure, Own};
use crate::run::{Run, hand_over};
use crate::scenario::Scenario;

/// A run that is stepped tick by tick.
#[pyclass(frozen, module = "trocar._core")]
pub(crate) struct Simulation {
    /// Locked because its parts can be sent, not shared, between threads; boxed because Python aligns to 16 bytes alone.
    run: Mutex<Option<Box<SteppedRun>>>,
    failure: Failure,
}

#[pymethods]
impl Simulation {
    #[new]
    fn new(py: Python<'_>, scenario: &Scenario, parts: &Bound<'_, PyDict>) -> PyResult<Self> {
        let Own { parts, failure, .. } = Own::of(parts)?;
        let run = SteppedRun::new(scenario.scenario.clone(), parts).map_err(|error| error::run(py, &error))?;
        Ok(Self { run: Mutex::new(Some(Box::new(run))), failure })
    }

    /// Runs a tick. Returns whether there are more.
    fn step(&self, py: Python<'_>, desired_position_m: Option<f64>) -> PyResult<bool> {
        if let Some(position_m) = desired_position_m.filter(|position_m| !position_m.is_finite()) {
            return Err(error::value(format!("desired_position_m is {position_m}, must be finite")));
        }
        let goes_on = self.locked().as_mut().ok_or_else(concluded)?.step(desired_position_m);
        match self.failure.take() {
            Some(error) => Err(error),
            None => goes_on.map_err(|error| error::run(py, &error)),
        }
    }

    /// The signals of the last tick, by column.
    fn signals<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let run = self.locked();
        let trace = run.as_ref().ok_or_else(concluded)?.trace();
        let signals = PyDict::new(py);
        for (name, values) in COLUMNS.into_iter().zip(trace.columns()) {
            match values {
                ColumnValues::Numbers(numbers) => signals.set_item(name, numbers.last())?,
                ColumnValues::Codes(codes) => signals.set_item(name, codes.last())?,
            }
        }
        Ok(signals)
    }

    /// Number of ticks so far.
    #[getter]
    fn ticks(&self) -> PyResult<u64> {
        Ok(self.locked().as_ref().ok_or_else(concluded)?.ticks())
    }

    /// The run and the columns of its trace so far; the simulation ends.
    fn conclude<'py>(&self, py: Python<'py>) -> PyResult<(Run, Bound<'py, PyDict>)> {
        let run = self.locked().take().ok_or_else(concluded)?;
        hand_over(py, run.conclude())
    }
}

impl Simulation {
    fn locked(&self) -> MutexGuard<'_, Option<Box<SteppedRun>>> {
        self.run.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

fn concluded() -> PyErr {
    error::value("the simulation has been concluded")
}
