//! The linear sides of the teleoperator, and its loop, as matrices.

use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;
use trocar_engine::plant::{ControlTiming, GeneralMaster, Machine, master_system, slave_system};
use trocar_lti::{self as lti, Complex64, Continuous, Discrete};
use trocar_stability::{ClosedLoop, LoopSystem, StabilityError};
use trocar_studies::stability_check::linear_loop;

use crate::arrays::matrix;
use crate::error;
use crate::interrupt::interruptible;
use crate::scenario::Scenario;

/// Times, and outputs by rows.
type Response<'py> = (Bound<'py, PyArray1<f64>>, Bound<'py, PyArray2<f64>>);

#[derive(Clone)]
enum System {
    /// `x' = A x + B u`.
    Continuous(lti::StateSpace<Continuous>),
    /// `x_{k+1} = A x_k + B u_k`.
    Discrete(lti::StateSpace<Discrete>),
}

macro_rules! either {
    ($this:expr, $system:ident => $value:expr) => {
        match &$this.system {
            System::Continuous($system) => $value,
            System::Discrete($system) => $value,
        }
    };
}

/// A side in continuous time, or the loop from tick to tick, with `y = C x + D u` and the names of its signals.
#[pyclass(frozen, module = "trocar._core")]
pub(crate) struct StateSpace {
    system: System,
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
        either!(self, system => matrix(py, rows!(system.a()), system.states()))
    }

    #[getter]
    fn b<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        either!(self, system => matrix(py, rows!(system.b()), system.inputs()))
    }

    #[getter]
    fn c<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        either!(self, system => matrix(py, rows!(system.c()), system.states()))
    }

    #[getter]
    fn d<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        either!(self, system => matrix(py, rows!(system.d()), system.inputs()))
    }

    /// The poles as (real, imaginary) parts.
    fn poles(&self) -> PyResult<Vec<(f64, f64)>> {
        let poles = either!(self, system => system.poles()).map_err(error::value)?;
        Ok(poles.into_iter().map(|pole| (pole.re, pole.im)).collect())
    }

    /// The time between two states, in s; `None` in continuous time.
    #[getter]
    fn tick_s(&self) -> Option<f64> {
        match &self.system {
            System::Continuous(_) => None,
            System::Discrete(system) => Some(system.tick_s()),
        }
    }

    /// Returns real and imaginary parts of the response from an input to an output at frequencies in Hz.
    fn frequency_response(&self, frequency_hz: Vec<f64>, input: usize, output: usize) -> PyResult<Vec<(f64, f64)>> {
        let at = |hertz: f64| -> PyResult<(f64, f64)> {
            let omega = std::f64::consts::TAU * hertz;
            let response = match &self.system {
                System::Continuous(system) => system.evaluate(Complex64::new(0.0, omega)),
                System::Discrete(system) => system.evaluate(Complex64::from_polar(1.0, omega * system.tick_s())),
            };
            let response = response.map_err(error::value)?;
            let value = response.get((output, input)).ok_or_else(|| error::value("no such input or output"))?;
            Ok((value.re, value.im))
        };
        frequency_hz.into_iter().map(at).collect()
    }

    /// Returns times, and outputs by rows, after a unit step of an input.
    fn step_response<'py>(
        &self,
        py: Python<'py>,
        input: usize,
        tick_s: f64,
        samples: usize,
    ) -> PyResult<Response<'py>> {
        let system = self.system.clone();
        let response = interruptible(py, 1, move |_| match &system {
            System::Continuous(system) => lti::step_response(system, input, tick_s, samples),
            System::Discrete(system) => lti::step_response_discrete(system, input, samples),
        });
        let response = response?.map_err(error::value)?;
        Ok((PyArray1::from_vec(py, response.time_s), matrix(py, rows!(response.outputs), samples)?))
    }
}

/// The matrices of a scenario's side or loop: the master with its arm, the slave, the loop gain or the closed
/// loop.
#[pyfunction]
pub(crate) fn state_space(py: Python<'_>, scenario: &Scenario, side: &str) -> PyResult<StateSpace> {
    let scenario = &scenario.scenario;
    let is_sampled = scenario.timing == ControlTiming::Sampled;
    match side {
        "master" if scenario.master_model.is_general() => {
            let trocar_scenario::Scenario { master, master_model, arm, .. } = scenario;
            let general = GeneralMaster { parameters: master, model: master_model, arm };
            of_side(
                general.machine().map_err(error::value)?.system().clone(),
                "master",
                vec!["motor_force_n", "hand_force_n"],
                vec!["master_position_m", "master_velocity_m_per_s"],
                &["master_position_m", "master_velocity_m_per_s"],
            )
        }
        "master" => of_side(
            master_system(&scenario.master, &scenario.arm, scenario.timing).map_err(error::value)?,
            "master",
            vec![
                "desired_position_m",
                "desired_velocity_m_per_s",
                if is_sampled { "motor_force_n" } else { "feedback_force_n" },
            ],
            vec!["operator_force_n", if is_sampled { "motor_minus_operator_force_n" } else { "force_error_n" }],
            &[
                "master_position_m",
                "master_velocity_m_per_s",
                "arm_position_m",
                "arm_velocity_m_per_s",
                "force_error_integral_n_s",
            ],
        ),
        "slave" => of_side(
            if scenario.has_general_machine() {
                Machine::of(&scenario.slave).map_err(error::value)?.system().clone()
            } else {
                slave_system(&scenario.slave, scenario.timing).map_err(error::value)?
            },
            "slave",
            match (scenario.has_general_machine(), is_sampled) {
                (true, _) => vec!["motor_command", "external_force_n"],
                (false, true) => vec!["motor_command"],
                (false, false) => vec!["slave_reference_m"],
            },
            vec!["slave_position_m", "slave_velocity_m_per_s"],
            &["slave_position_m", "slave_velocity_m_per_s"],
        ),
        "loop-gain" => of_loop(py, scenario, "loop-gain", ClosedLoop::loop_gain_system),
        "closed-loop" => of_loop(py, scenario, "closed-loop", ClosedLoop::closed_loop_system),
        other => Err(error::value(format!(
            "side is {other:?}, must be \"master\", \"slave\", \"loop-gain\" or \"closed-loop\""
        ))),
    }
}

fn of_side(
    system: lti::StateSpace<Continuous>,
    name: &'static str,
    inputs: Vec<&'static str>,
    outputs: Vec<&'static str>,
    known: &[&str],
) -> PyResult<StateSpace> {
    let state = |index: usize| known.get(index).map_or_else(|| format!("state_{index}"), |name| (*name).to_owned());
    let states = (0..system.states()).map(state).collect();
    Ok(StateSpace { system: System::Continuous(system), name, inputs, outputs, states })
}

fn of_loop(
    py: Python<'_>,
    scenario: &trocar_scenario::Scenario,
    name: &'static str,
    form: impl Fn(&ClosedLoop) -> Result<LoopSystem, StabilityError>,
) -> PyResult<StateSpace> {
    let settings = linear_loop(scenario).map_err(|error| error::check(py, &error))?;
    let closed = ClosedLoop::new(&settings).map_err(error::value)?;
    let system = form(&closed).map_err(error::value)?;
    let states = (0..system.system.states()).map(|index| format!("state_{index}")).collect();
    let (inputs, outputs) = (system.inputs, system.outputs);
    Ok(StateSpace { system: System::Discrete(system.system), name, inputs, outputs, states })
}
