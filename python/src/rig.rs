//! The controller of a rig.

use numpy::{PyArray1, PyReadonlyArray1};
use pyo3::prelude::*;
use trocar_core::lane::Stored as _;
use trocar_core::rig::{self, Faults, Sample, Settings};
use trocar_scenario::ScenarioError;

use crate::error;
use crate::scenario::Scenario;

#[pyclass(module = "trocar._core")]
pub(crate) struct HapticController {
    controller: Box<rig::HapticController>,
    initial: Box<rig::HapticController>,
}

#[pyclass(frozen, get_all, module = "trocar._core")]
pub(crate) struct Command {
    slave_reference_m: f64,
    master_force_n: f64,
    mode: u8,
    alarm: bool,
    alarm_taken: bool,
    stiffness_n_per_m: f64,
    damping_n_s_per_m: f64,
    predicted_force_n: f64,
    residual_n: f64,
    distance: f64,
    decision: f64,
    slave_velocity_m_per_s: f64,
    faults: Vec<&'static str>,
    faulty_samples: u32,
}

/// The channels of a sample, by the names of faults.
const CHANNELS: [&str; 4] = ["master_position", "slave_position", "slave_velocity", "force"];

/// The numbers of a command, its mode, true for an alarm and for a taken alarm, the faulty channels, and the number
/// of faulty samples.
type CommandParts = ([f64; 9], u8, (bool, bool), Vec<String>, u32);

#[pymethods]
impl Command {
    /// Restores a pickled command.
    #[new]
    fn new(numbers: [f64; 9], mode: u8, alarms: (bool, bool), faults: Vec<String>, faulty_samples: u32) -> Self {
        let [
            slave_reference_m,
            master_force_n,
            stiffness_n_per_m,
            damping_n_s_per_m,
            predicted_force_n,
            residual_n,
            distance,
            decision,
            slave_velocity_m_per_s,
        ] = numbers;
        let (alarm, alarm_taken) = alarms;
        Self {
            slave_reference_m,
            master_force_n,
            mode,
            alarm,
            alarm_taken,
            stiffness_n_per_m,
            damping_n_s_per_m,
            predicted_force_n,
            residual_n,
            distance,
            decision,
            slave_velocity_m_per_s,
            faults: CHANNELS.into_iter().filter(|name| faults.iter().any(|fault| fault == name)).collect(),
            faulty_samples,
        }
    }

    /// The arguments with which [`Command::new`] restores this command.
    fn __getnewargs__(&self) -> CommandParts {
        let numbers = [
            self.slave_reference_m,
            self.master_force_n,
            self.stiffness_n_per_m,
            self.damping_n_s_per_m,
            self.predicted_force_n,
            self.residual_n,
            self.distance,
            self.decision,
            self.slave_velocity_m_per_s,
        ];
        let faults = self.faults.iter().map(|fault| (*fault).to_owned()).collect();
        (numbers, self.mode, (self.alarm, self.alarm_taken), faults, self.faulty_samples)
    }

    fn __repr__(&self) -> String {
        let Self { slave_reference_m, master_force_n, mode, .. } = self;
        format!("Command(slave_reference_m={slave_reference_m:?}, master_force_n={master_force_n:?}, mode={mode}, …)")
    }
}

#[pymethods]
impl HapticController {
    /// The controller of a scenario, with values of the keys `rig.…`.
    #[new]
    fn new(py: Python<'_>, scenario: &Scenario, changes: Vec<(String, f64)>) -> PyResult<Self> {
        let refuse = |error: ScenarioError| error::scenario(py, &error);
        let key_of = |(path, value): (String, f64)| {
            let key = Settings::KEYS.iter().find(|key| key.path == path && path.starts_with("rig."));
            let named =
                || error::value(format!("there is no {path}; `trocar.HapticController` lists the keys of a rig"));
            Ok::<_, PyErr>((key.ok_or_else(named)?.path, value))
        };
        let changes = changes.into_iter().map(key_of).collect::<PyResult<Vec<_>>>()?;
        let settings = scenario.scenario.rig_settings_with(&changes).map_err(refuse)?;
        let controller = Box::new(rig::HapticController::new(&settings).map_err(error::value)?);
        Ok(Self { initial: controller.clone(), controller })
    }

    /// Processes a sample. NaN marks a missing number.
    fn step(
        &mut self,
        master_position_m: f64,
        slave_position_m: f64,
        slave_velocity_m_per_s: f64,
        force_n: f64,
    ) -> Command {
        let sample = Sample { master_position_m, slave_position_m, slave_velocity_m_per_s, force_n };
        let command = self.controller.step(&sample);
        let Faults { master_position, slave_position, slave_velocity, force } = command.faults;
        let faulty = [master_position, slave_position, slave_velocity, force];
        Command {
            slave_reference_m: command.slave_reference_m,
            master_force_n: command.master_force_n,
            mode: command.mode.code(),
            alarm: command.alarm,
            alarm_taken: command.alarm_taken,
            stiffness_n_per_m: command.stiffness_n_per_m,
            damping_n_s_per_m: command.damping_n_s_per_m,
            predicted_force_n: command.predicted_force_n,
            residual_n: command.residual_n,
            distance: command.distance,
            decision: command.decision,
            slave_velocity_m_per_s: command.slave_velocity_m_per_s,
            faults: CHANNELS
                .into_iter()
                .zip(faulty)
                .filter_map(|(name, is_faulty)| is_faulty.then_some(name))
                .collect(),
            faulty_samples: command.faulty_samples,
        }
    }

    fn reset(&mut self) {
        self.controller = self.initial.clone();
    }

    fn state<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u64>> {
        PyArray1::from_vec(py, self.controller.state())
    }

    /// Restores the state of a controller with the same settings.
    fn restore(&mut self, state: PyReadonlyArray1<'_, u64>) -> PyResult<()> {
        self.controller.restore(state.as_slice().map_err(error::value)?).map_err(error::value)
    }

    /// A controller in the same state.
    fn copy(&self) -> Self {
        Self { controller: self.controller.clone(), initial: self.initial.clone() }
    }
}
