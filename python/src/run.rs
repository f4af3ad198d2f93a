//! Runs of scenarios.

use std::collections::HashMap;
use std::time::{Duration, Instant};

use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use trocar_document::Study as _;
use trocar_document::to_json;
use trocar_engine::engine::{COLUMNS, ColumnValues, Observer, Signals, TRACE_COLUMNS, TRUST_COLUMNS};
use trocar_metrics::{Metrics, RunMetric};
use trocar_studies::run::{RunError, RunReport, observe, observe_with};

use crate::arrays::put;
use crate::figures::run_trust;
use crate::interrupt::interruptible;
use crate::scenario::Scenario;
use crate::user_defined::{CompiledParts, Failure, UserDefined};
use crate::{convert, document, error};

/// Number of ticks between two readings of the clock, and time between two checks for signals. A tick takes about 30
/// ns.
const TICKS: u64 = 4096;
const PERIOD: Duration = Duration::from_millis(10);

/// Number of ticks above which the work after a run can take long and runs on its own thread, which Ctrl-C can
/// interrupt.
const MANY_TICKS: u64 = 200_000;

/// A run without its trace.
#[pyclass(frozen, module = "trocar._core")]
pub(crate) struct Run {
    run: trocar_studies::run::Run,
}

#[pymethods]
impl Run {
    /// The content of `summary.json`.
    fn summary<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        convert::parsed(py, &to_json(&RunReport::of(&self.run).summary()))
    }

    /// Returns only the warnings of `summary.json`.
    fn warnings<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let all = serde_json::to_value(RunReport::of(&self.run).warnings()).map_err(error::value)?;
        convert::python(py, &all)
    }

    /// Returns `summary.json` as text.
    fn summary_json(&self) -> String {
        to_json(&RunReport::of(&self.run).summary())
    }

    /// The document, without its figures.
    fn document<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        document::dictionary(py, &RunReport::of(&self.run).document(), false)
    }

    fn trust<'py>(&self, py: Python<'py>, columns: &Bound<'py, PyDict>) -> PyResult<Bound<'py, PyDict>> {
        let trust = run_trust(&self.run.scenario, columns)?;
        let all = PyDict::new(py);
        let [stiffness, damping, excitation, flags] = TRUST_COLUMNS.map(|column| column.name);
        put(&all, stiffness, trust.stiffness_std_n_per_m)?;
        put(&all, damping, trust.damping_std_n_s_per_m)?;
        put(&all, excitation, trust.excitation)?;
        put(&all, flags, trust.estimate_flags)?;
        Ok(all)
    }

    /// Every metric under its name in sweeps, in SI units.
    fn named_metrics(&self) -> HashMap<String, Option<f64>> {
        let metrics = &self.run.metrics;
        let all = RunMetric::of_run_with(metrics.ruptures.len(), metrics.events.len());
        all.map(|metric| (metric.key(), metric.read(metrics))).collect()
    }

    #[getter]
    fn name(&self) -> &str {
        &self.run.scenario.name
    }
}

/// Watches for signals and for exceptions of user-defined parts, which end the run.
#[derive(Default)]
struct Watch {
    last_check: Option<Instant>,
    signal: Option<PyErr>,
    failure: Failure,
}

impl Observer<f64> for Watch {
    #[inline(always)]
    fn observe(&mut self, signals: &Signals<f64>) {
        if signals.tick.is_multiple_of(TICKS) && signals.tick > 0 {
            self.check_signals();
        }
    }

    #[inline(always)]
    fn is_done(&self) -> bool {
        self.signal.is_some() || self.failure.has_failed()
    }
}

impl Watch {
    #[cold]
    #[inline(never)]
    fn check_signals(&mut self) {
        let last_check = self.last_check.get_or_insert_with(Instant::now);
        if last_check.elapsed() >= PERIOD {
            *last_check = Instant::now();
            self.signal = Python::attach(|py| py.check_signals()).err();
        }
    }

    fn ended(self) -> PyResult<()> {
        self.failure.take().or(self.signal).map_or(Ok(()), Err)
    }
}

/// Runs a scenario. Returns the run and the columns of its trace, without the columns of [`Run::trust`].
#[pyfunction]
pub(crate) fn run<'py>(py: Python<'py>, scenario: &Scenario) -> PyResult<(Run, Bound<'py, PyDict>)> {
    let scenario = &scenario.scenario;
    let (outcome, trace, watch) = py.detach(|| {
        let mut trace = trocar_studies::run::empty_trace(scenario);
        let mut watch = Watch::default();
        let outcome = observe(scenario, &mut (trace.recorder(), &mut watch));
        (outcome, trace, watch)
    });
    watch.ended()?;
    let metrics = outcome.map_err(|error| error::run(py, &error))?;
    let scenario = scenario.clone();
    let run = if scenario.grid.ticks() < MANY_TICKS {
        py.detach(|| trocar_studies::run::Run::concluded(scenario, metrics, trace))
    } else {
        interruptible(py, 1, move |_| trocar_studies::run::Run::concluded(scenario, metrics, trace))?
    };
    hand_over(py, run.map_err(|error| error::run(py, &error))?)
}

/// Runs a scenario with user-defined parts, by role. Returns the run and the columns of its trace.
#[pyfunction]
pub(crate) fn run_with<'py>(
    py: Python<'py>,
    scenario: &Scenario,
    parts: &Bound<'py, PyDict>,
) -> PyResult<(Run, Bound<'py, PyDict>)> {
    hand_over(py, traced_with(py, &scenario.scenario, parts)?)
}

pub(crate) fn traced_with(
    py: Python<'_>,
    scenario: &trocar_scenario::Scenario,
    parts: &Bound<'_, PyDict>,
) -> PyResult<trocar_studies::run::Run> {
    let parts = UserDefined::of(parts)?;
    let roles = parts.parts.roles();
    let mut trace = trocar_studies::run::empty_trace_with(scenario, &parts.parts);
    let metrics = observed(py, scenario, parts, &mut trace.recorder())?.map_err(|error| error::run(py, &error))?;
    Ok(trocar_studies::run::Run::of_user_defined_parts(scenario.clone(), roles, metrics, trace))
}

pub(crate) fn measure_with(
    py: Python<'_>,
    scenario: &trocar_scenario::Scenario,
    parts: &Bound<'_, PyDict>,
) -> PyResult<Result<Metrics, RunError>> {
    observed(py, scenario, UserDefined::of(parts)?, &mut ())
}

/// Runs a scenario with compiled parts for its metrics, on a thread of the pool.
pub(crate) fn measure_compiled(
    scenario: &trocar_scenario::Scenario,
    parts: &CompiledParts,
) -> PyResult<Result<Metrics, RunError>> {
    let UserDefined { parts, failure, .. } = parts.begin();
    let outcome = observe_with(scenario, parts, &mut Failing(&failure));
    failure.take().map_or(Ok(outcome), Err)
}

struct Failing<'a>(&'a Failure);

impl Observer<f64> for Failing<'_> {
    fn observe(&mut self, _: &Signals<f64>) {}

    fn is_done(&self) -> bool {
        self.0.has_failed()
    }
}

fn observed<O: Observer<f64> + Send>(
    py: Python<'_>,
    scenario: &trocar_scenario::Scenario,
    UserDefined { parts, failure, are_compiled }: UserDefined,
    observer: &mut O,
) -> PyResult<Result<Metrics, RunError>> {
    let mut watched = (observer, Watch { failure, ..Watch::default() });
    let work = || observe_with(scenario, parts, &mut watched);
    // A Python function needs the interpreter at every tick, so keep the lock during the whole run.
    let outcome = if are_compiled { py.detach(work) } else { work() };
    watched.1.ended()?;
    Ok(outcome)
}

pub(crate) fn hand_over(py: Python<'_>, mut run: trocar_studies::run::Run) -> PyResult<(Run, Bound<'_, PyDict>)> {
    let columns = PyDict::new(py);
    let trace = &mut run.trace;
    for (name, values) in COLUMNS.into_iter().zip(trace.take_columns()) {
        match values {
            ColumnValues::Numbers(numbers) => put(&columns, name, numbers)?,
            ColumnValues::Codes(codes) => put(&columns, name, codes)?,
        }
    }
    if let Some((name, values)) = &trace.extra_parameter {
        // The summary also needs this column, so copy it.
        columns.set_item(*name, PyArray1::from_slice(py, values))?;
    }
    Ok((Run { run }, columns))
}

#[pyfunction]
pub(crate) fn trace_columns() -> Vec<(&'static str, &'static str, &'static str)> {
    TRACE_COLUMNS.iter().chain(&TRUST_COLUMNS).map(|column| (column.name, column.unit, column.meaning)).collect()
}

#[pyfunction]
pub(crate) fn seconds_of_run(py: Python<'_>, scenario: &Scenario) -> f64 {
    py.detach(|| {
        let begun = Instant::now();
        let run = trocar_studies::run::run(scenario.scenario.clone());
        let seconds = begun.elapsed().as_secs_f64();
        drop(std::hint::black_box(run));
        seconds
    })
}
