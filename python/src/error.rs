//! Conversion of errors to Python exceptions: invalid input is a `ValueError`, any other error a `RuntimeError`.

use pyo3::exceptions::{PyOSError, PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::PyType;
use trocar_report::diagnostic;
use trocar_sim::run::RunError;
use trocar_sim::scenario::ScenarioError;
use trocar_sim::stability::StabilityError;
use trocar_sim::stability_check::CheckError;
use trocar_sim::sweep::SweepError;

/// Returns a `trocar.ScenarioError`: the text of the command line with the underlined line, and its parts as attributes.
pub(crate) fn scenario(py: Python<'_>, error: &ScenarioError) -> PyErr {
    static CLASS: PyOnceLock<Py<PyType>> = PyOnceLock::new();
    let class = match CLASS.import(py, "trocar._errors", "ScenarioError") {
        Ok(class) => class,
        Err(error) => return error,
    };
    let text = anstream::adapter::strip_str(&diagnostic::scenario_error(error)).to_string();
    let (file, line, column) = match &error.place {
        Some(place) => {
            let (line, column) = place.line_and_column();
            (Some(&*place.file), Some(line), Some(column))
        }
        None => (None, None, None),
    };
    match class.call1((text, &error.message, error.remedy.as_ref(), file, line, column)) {
        Ok(exception) => PyErr::from_value(exception),
        Err(error) => error,
    }
}

/// Returns a `ValueError` for invalid input.
pub(crate) fn value(error: impl ToString) -> PyErr {
    PyValueError::new_err(error.to_string())
}

pub(crate) fn run(py: Python<'_>, error: &RunError) -> PyErr {
    match error {
        RunError::Scenario(error) => scenario(py, error),
        other @ RunError::Engine { .. } => PyRuntimeError::new_err(other.to_string()),
    }
}

pub(crate) fn sweep(py: Python<'_>, error: &SweepError) -> PyErr {
    match error {
        SweepError::File(error) => scenario(py, error),
        SweepError::Case { case, values, source } => match &**source {
            RunError::Scenario(error) => {
                let mut error = error.clone();
                error.message = format!("case {case} ({values}): {}", error.message);
                scenario(py, &error)
            }
            other => PyRuntimeError::new_err(other.to_string()),
        },
        SweepError::Changed { .. } | SweepError::Parts { .. } => value(error),
        SweepError::Io { .. } | SweepError::Busy { .. } => PyOSError::new_err(error.to_string()),
    }
}

pub(crate) fn stability(error: &StabilityError) -> PyErr {
    match error {
        StabilityError::Plant(_) | StabilityError::Parameter(_) => value(error),
        _ => PyRuntimeError::new_err(error.to_string()),
    }
}

pub(crate) fn check(py: Python<'_>, error: &CheckError) -> PyErr {
    match error {
        CheckError::Stability(error) => stability(error),
        CheckError::Run(error) => run(py, error),
    }
}
