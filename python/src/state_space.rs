//! The linear sides of the teleoperator as matrices.

use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;
use trocar_sim::lti::{self, Continuous};
use trocar_sim::plant::{ControlTiming, master_system, slave_system};

use crate::arrays::matrix;
use crate::error;
use crate::scenario::Scenario;

/// Times, and outputs by rows.
type Response<'py> = (Bound<'py, PyArray1<f64>>, Bound<'py, PyArray2<f64>>);

/// A side in continuous time, `x' = A x + B u`, `y = C x + D u`, with the names of its signals.
#[pyclass(frozen, module = "trocar._core")]
pub(crate) struct StateSpace {
    system: lti::StateSpace<Continuous>,
    #[pyo3(get)]
    name: &'static str,
    #[pyo3(get)]
    inputs: Vec<&'static str>,
    #[pyo3(get)]
    outputs: Vec<&'static str>,
    #[pyo3(get)]
    states: Vec<String>,
}

macro_rules! rows {
    ($matrix:expr) => {
        $matrix.row_iter().map(|row| row.iter().copied().collect()).collect::<Vec<Vec<f64>>>()
    };
}

#[pymethods]
impl StateSpace {
    #[getter]
    fn a<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        matrix(py, rows!(self.system.a()), self.system.states())
    }

    #[getter]
    fn b<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        matrix(py, rows!(self.system.b()), self.system.inputs())
    }

    #[getter]
    fn c<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        matrix(py, rows!(self.system.c()), self.system.states())
    }

    #[getter]
    fn d<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        matrix(py, rows!(self.system.d()), self.system.inputs())
    }

    /// Returns the poles as (real, imaginary) parts.
    fn poles(&self) -> PyResult<Vec<(f64, f64)>> {
        let poles = self.system.poles().map_err(error::value)?;
        Ok(poles.into_iter().map(|pole| (pole.re, pole.im)).collect())
    }

    /// Returns times, and outputs by rows, after a unit step of an input.
    fn step_response<'py>(
        &self,
        py: Python<'py>,
        input: usize,
        tick_s: f64,
        samples: usize,
    ) -> PyResult<Response<'py>> {
        let response = lti::step_response(&self.system, input, tick_s, samples).map_err(error::value)?;
        Ok((PyArray1::from_vec(py, response.time_s), matrix(py, rows!(response.outputs), samples)?))
    }
}

/// Returns the master with its arm, or the slave, of a scenario.
#[pyfunction]
pub(crate) fn state_space(scenario: &Scenario, side: &str) -> PyResult<StateSpace> {
    let scenario = &scenario.scenario;
    let is_sampled = scenario.timing == ControlTiming::Sampled;
    let (system, name, inputs, outputs) = match side {
        "master" => (
            master_system(&scenario.master, &scenario.arm, scenario.timing),
            "master",
            vec![
                "desired_position_m",
                "desired_velocity_m_per_s",
                if is_sampled { "motor_force_n" } else { "feedback_force_n" },
            ],
            vec!["operator_force_n", if is_sampled { "motor_minus_operator_force_n" } else { "force_error_n" }],
        ),
        "slave" => (
            slave_system(&scenario.slave, scenario.timing),
            "slave",
            vec![if is_sampled { "motor_command" } else { "slave_reference_m" }],
            vec!["slave_position_m", "slave_velocity_m_per_s"],
        ),
        other => return Err(error::value(format!("side is {other:?}, must be \"master\" or \"slave\""))),
    };
    let system = system.map_err(error::value)?;
    let known: &[&str] = match side {
        "master" => &[
            "master_position_m",
            "master_velocity_m_per_s",
            "arm_position_m",
            "arm_velocity_m_per_s",
            "force_error_integral_n_s",
        ],
        _ => &["slave_position_m", "slave_velocity_m_per_s"],
    };
    let state = |index: usize| known.get(index).map_or_else(|| format!("state_{index}"), |name| (*name).to_owned());
    let states = (0..system.states()).map(state).collect();
    Ok(StateSpace { system, name, inputs, outputs, states })
}
