//! A simulation that is stepped tick by tick.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

use numpy::{PyArray1, PyReadonlyArray1};
use pyo3::IntoPyObjectExt;
use pyo3::exceptions::{PyKeyError, PyRuntimeError};
use pyo3::prelude::*;
use pyo3::sync::MutexExt;
use pyo3::types::PyDict;
use trocar_engine::engine::{COLUMNS, ColumnValues};
use trocar_studies::run::SteppedRun;

use crate::error;
use crate::run::{Run, hand_over};
use crate::scenario::Scenario;
use crate::user_defined::{Failure, UserDefined};

/// The last value of a column for Python; `None` for an empty column.
fn last<'py>(py: Python<'py>, values: ColumnValues<&[f64], &[u8]>) -> PyResult<Bound<'py, PyAny>> {
    match values {
        ColumnValues::Numbers(numbers) => numbers.last().into_bound_py_any(py),
        ColumnValues::Codes(codes) => codes.last().into_bound_py_any(py),
    }
}

/// A run that is stepped tick by tick.
#[pyclass(frozen, module = "trocar._core")]
pub(crate) struct Simulation {
    /// Locked because its parts can be sent to other threads but not shared. Boxed because Python aligns only to 16
    /// bytes.
    run: Mutex<State>,
    /// The thread that currently runs a tick, as the address of its [`HERE`]; 0 for none.
    in_tick: AtomicUsize,
    failure: Failure,
}

enum State {
    Running(Box<SteppedRun>),
    /// An error, or an exception of a part, ended it after this number of ticks.
    Failed(u64),
    /// Its result was taken after this number of ticks.
    Concluded(u64),
}

impl State {
    fn running(&mut self) -> PyResult<&mut SteppedRun> {
        match self {
            Self::Running(run) => Ok(run),
            Self::Failed(_) => Err(error::value("the simulation has ended with an error")),
            Self::Concluded(_) => Err(error::value("the simulation has been concluded")),
        }
    }

    fn ticks(&self) -> u64 {
        match self {
            Self::Running(run) => run.ticks(),
            Self::Failed(ticks) | Self::Concluded(ticks) => *ticks,
        }
    }
}

thread_local! {
    /// A variable whose address identifies the thread.
    static HERE: u8 = const { 0 };
}

fn this_thread() -> usize {
    HERE.with(|here| std::ptr::from_ref(here).addr())
}

#[pymethods]
impl Simulation {
    #[new]
    fn new(py: Python<'_>, scenario: &Scenario, parts: &Bound<'_, PyDict>) -> PyResult<Self> {
        let UserDefined { parts, failure, .. } = UserDefined::of(parts)?;
        let run = SteppedRun::new(scenario.scenario.clone(), parts).map_err(|error| error::run(py, &error))?;
        Ok(Self::of(run, failure))
    }

    /// Runs a tick. Returns true if more ticks follow.
    fn step(&self, py: Python<'_>, desired_position_m: Option<f64>) -> PyResult<bool> {
        if let Some(position_m) = desired_position_m.filter(|position_m| !position_m.is_finite()) {
            return Err(error::value(format!("desired_position_m is {position_m}, must be finite")));
        }
        let mut state = self.locked(py)?;
        let run = state.running()?;
        self.in_tick.store(this_thread(), Ordering::Relaxed);
        let goes_on = run.step(desired_position_m);
        self.in_tick.store(0, Ordering::Relaxed);
        let outcome = match self.failure.take() {
            Some(error) => Err(error),
            None => goes_on.map_err(|error| error::run(py, &error)),
        };
        if outcome.is_err() {
            *state = State::Failed(state.ticks());
        }
        outcome
    }

    fn signals<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let mut state = self.locked(py)?;
        let trace = state.running()?.trace();
        let signals = PyDict::new(py);
        for (name, values) in COLUMNS.into_iter().zip(trace.columns()) {
            signals.set_item(name, last(py, values)?)?;
        }
        Ok(signals)
    }

    /// One of [`Simulation::signals`].
    fn signal<'py>(&self, py: Python<'py>, column: &str) -> PyResult<Bound<'py, PyAny>> {
        let place = COLUMNS.iter().position(|name| *name == column).ok_or_else(|| {
            PyKeyError::new_err(format!("no signal {column:?}; the signals are {}", COLUMNS.join(", ")))
        })?;
        let mut state = self.locked(py)?;
        last(py, state.running()?.trace().columns()[place])
    }

    /// Runs a tick for each imposed position of the operator in m; NaN where none is imposed.
    fn repeat(&self, py: Python<'_>, led_m: PyReadonlyArray1<'_, f64>) -> PyResult<()> {
        let led_m = led_m.as_slice().map_err(error::value)?;
        let mut state = self.locked(py)?;
        let run = state.running()?;
        py.detach(|| run.repeat(led_m)).map_err(|error| error::run(py, &error))
    }

    /// Continues with the parts of a changed scenario that belong to the sections of the changed keys.
    fn change(&self, py: Python<'_>, changed: &Scenario, sections: Vec<String>) -> PyResult<()> {
        let sections: Vec<&str> = sections.iter().map(String::as_str).collect();
        let mut state = self.locked(py)?;
        state.running()?.change(&changed.scenario, &sections).map_err(|error| error::run(py, &error))
    }

    /// The imposed position of the operator at each tick so far, in m; NaN where none was imposed.
    fn led_m<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        Ok(PyArray1::from_slice(py, self.locked(py)?.running()?.led_m()))
    }

    #[getter]
    fn ticks(&self, py: Python<'_>) -> PyResult<u64> {
        Ok(self.locked(py)?.ticks())
    }

    /// Ends the simulation. Returns the run and the columns of its trace so far.
    fn conclude<'py>(&self, py: Python<'py>) -> PyResult<(Run, Bound<'py, PyDict>)> {
        let mut state = self.locked(py)?;
        state.running()?;
        let ticks = state.ticks();
        let State::Running(run) = std::mem::replace(&mut *state, State::Concluded(ticks)) else {
            return Err(error::value("the simulation has been concluded"));
        };
        drop(state);
        hand_over(py, run.conclude())
    }
}

impl Simulation {
    fn of(run: SteppedRun, failure: Failure) -> Self {
        Self { run: Mutex::new(State::Running(Box::new(run))), in_tick: AtomicUsize::new(0), failure }
    }

    /// Waits for a tick of another thread. Releases the interpreter, which that tick's parts may need.
    fn locked(&self, py: Python<'_>) -> PyResult<MutexGuard<'_, State>> {
        if self.in_tick.load(Ordering::Relaxed) == this_thread() {
            return Err(PyRuntimeError::new_err(
                "a part cannot use the simulation that contains it; use the arguments of the part instead",
            ));
        }
        Ok(self.run.lock_py_attached(py).unwrap_or_else(PoisonError::into_inner))
    }
}

/// The stiffness of the arm at rest, from the desired position to the master, in N/m.
#[pyfunction]
pub(crate) fn arm_stiffness(scenario: &Scenario) -> f64 {
    scenario.scenario.arm.static_stiffness_n_per_m()
}
