//! Running a scenario.

use std::time::{Duration, Instant};

use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use trocar_report::{run_text, summary_json};
use trocar_sim::engine::{COLUMNS, ColumnValues, Observer, Signals, TRACE_COLUMNS, Trace};
use trocar_sim::run::observe;

use crate::arrays::put;
use crate::scenario::Scenario;
use crate::{convert, error};

/// After how many ticks the clock is looked at, and after what time signals are: a tick takes some 30 ns.
const TICKS: u64 = 4096;
const PERIOD: Duration = Duration::from_millis(40);

/// A scenario that was run; its trace has been handed over.
#[pyclass(frozen, module = "trocar._core")]
pub(crate) struct Run {
    run: trocar_sim::run::Run,
}

#[pymethods]
impl Run {
    /// What `summary.json` holds.
    fn summary<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        convert::parsed(py, &summary_json(&self.run))
    }

    /// The same, as text.
    fn summary_json(&self) -> String {
        summary_json(&self.run)
    }

    /// What the command line prints of it.
    fn text(&self) -> String {
        run_text(&self.run)
    }

    /// The table's rows: metric, label, unit, value in SI.
    fn rows(&self) -> Vec<(String, String, &'static str, Option<f64>)> {
        let rows = trocar_sim::compare::rows(&[&self.run.metrics], &[]);
        rows.into_iter().map(|row| (row.metric, row.label, row.unit.si(), row.values[0])).collect()
    }

    #[getter]
    fn name(&self) -> &str {
        &self.run.scenario.name
    }
}

/// Records every tick, and looks for signals now and then; the run ends where there is one.
struct Watch {
    trace: Trace,
    looked: Option<Instant>,
    signal: Option<PyErr>,
}

impl Observer<f64> for Watch {
    #[inline(always)]
    fn observe(&mut self, signals: &Signals<f64>) {
        self.trace.observe(signals);
        if signals.tick.is_multiple_of(TICKS) && signals.tick > 0 {
            self.look();
        }
    }

    #[inline(always)]
    fn is_done(&self) -> bool {
        self.signal.is_some()
    }
}

impl Watch {
    #[cold]
    #[inline(never)]
    fn look(&mut self) {
        let looked = self.looked.get_or_insert_with(Instant::now);
        if looked.elapsed() >= PERIOD {
            *looked = Instant::now();
            self.signal = Python::attach(|py| py.check_signals()).err();
        }
    }
}

/// Runs a scenario; gives the run and its trace by columns.
#[pyfunction]
pub(crate) fn run<'py>(py: Python<'py>, scenario: &Scenario) -> PyResult<(Run, Bound<'py, PyDict>)> {
    let scenario = &scenario.scenario;
    let (outcome, Watch { trace, signal, .. }) = py.detach(|| {
        let trace =
            Trace::new(scenario.grid).with_extra_parameter(scenario.estimator.parameters.extra_parameter_column());
        let mut watch = Watch { trace, looked: None, signal: None };
        let outcome = observe(scenario, &mut watch);
        (outcome, watch)
    });
    if let Some(signal) = signal {
        return Err(signal);
    }
    let metrics = outcome.map_err(|error| error::run(py, &error))?;
    hand_over(py, trocar_sim::run::Run { scenario: scenario.clone(), metrics, trace })
}

/// A run, and its trace as arrays: the very vectors, without a copy.
pub(crate) fn hand_over(py: Python<'_>, mut run: trocar_sim::run::Run) -> PyResult<(Run, Bound<'_, PyDict>)> {
    let columns = PyDict::new(py);
    let trace = &mut run.trace;
    for (name, values) in COLUMNS.into_iter().zip(trace.take_columns()) {
        match values {
            ColumnValues::Numbers(numbers) => put(&columns, name, numbers)?,
            ColumnValues::Codes(codes) => put(&columns, name, codes)?,
        }
    }
    if let Some((name, values)) = &trace.extra_parameter {
        // The summary needs it too.
        columns.set_item(*name, PyArray1::from_slice(py, values))?;
    }
    Ok((Run { run }, columns))
}

/// The columns of a trace: name, unit, meaning.
#[pyfunction]
pub(crate) fn trace_columns() -> Vec<(&'static str, &'static str, &'static str)> {
    TRACE_COLUMNS.iter().map(|column| (column.name, column.unit, column.meaning)).collect()
}

/// How long the crate's own `run` takes for a scenario, in s: the least of some times.
#[pyfunction]
pub(crate) fn seconds_of_run(py: Python<'_>, scenario: &Scenario, times: usize) -> f64 {
    py.detach(|| {
        let once = || {
            let begun = Instant::now();
            let run = trocar_sim::run::run(scenario.scenario.clone());
            let seconds = begun.elapsed().as_secs_f64();
            drop(std::hint::black_box(run));
            seconds
        };
        (0..times.max(1)).map(|_| once()).fold(f64::INFINITY, f64::min)
    })
}
