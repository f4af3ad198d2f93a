//! The controller of a rig.

use numpy::{PyArray1, PyReadonlyArray1};
use pyo3::prelude::*;
use trocar_core::lane::Stored as _;
use trocar_core::rig::{self, Counters, DetectionState, Faults, Sample, Settings};
use trocar_core::safety::{FaultCause, Limited, SafetyCounts, SafetyState};
use trocar_core::settings::Kind;
use trocar_scenario::ScenarioError;

use crate::error;
use crate::scenario::Scenario;

#[pyclass(module = "trocar._core")]
pub(crate) struct HapticController {
    controller: Box<rig::HapticController>,
    initial: Box<rig::HapticController>,
}

/// The command of a rig's controller at one sample, in SI units, returned by `HapticController.step`.
///
/// ```text
/// >>> import trocar
/// >>> command = trocar.HapticController("paper/augmented").step(0.015, 0.0149, 0.01, 1.2)
/// >>> command.slave_reference_m, command.state
/// (0.015, 'active')
///
/// ```
#[pyclass(frozen, get_all, module = "trocar._core")]
pub(crate) struct Command {
    /// The reference for the slave's position controller, in m.
    slave_reference_m: f64,
    /// The force for the master's force controller, in N.
    master_force_n: f64,
    /// The mode: 0 teleoperation, 1 augmented, 2 re-engaging.
    mode: u8,
    /// True if the detector raises an alarm.
    alarm: bool,
    /// True if the supervisor accepts the alarm, which begins an event.
    alarm_taken: bool,
    /// Estimated stiffness, in N/m.
    stiffness_n_per_m: f64,
    /// Estimated damping, in N·s/m.
    damping_n_s_per_m: f64,
    /// Force that the estimator predicted before this sample, in N.
    predicted_force_n: f64,
    /// The measured force minus the predicted one, in N.
    residual_n: f64,
    /// The distance, whose unit depends on `detector.distance`.
    distance: f64,
    /// The decision, which raises an alarm above `detector.threshold`.
    decision: f64,
    /// The velocity of the slave as used, in m/s.
    slave_velocity_m_per_s: f64,
    /// The names of the faulty channels of this sample.
    faults: Vec<&'static str>,
    /// The number of consecutive faulty samples.
    faulty_samples: u32,
    /// The state of the detection: `"armed"`, `"settling"` or `"blind"`.
    detection: &'static str,
    /// The number of ticks since which the detection is in this state.
    detection_ticks: u32,
    /// The state of the commands: `"disabled"`, `"aligning"`, `"active"` or `"fault"`.
    state: &'static str,
    /// The cause of the last fault, or `None`.
    fault: Option<&'static str>,
    /// The names of the limits `safety.…` that acted.
    limited: Vec<&'static str>,
}

/// The limits of a command, by their names.
const LIMITS: [&str; 4] = ["force", "force_rate", "reference_speed", "lead"];

/// The channels of a sample, by the names of faults.
const CHANNELS: [&str; 4] = ["master_position", "slave_position", "slave_velocity", "force"];

/// The numbers of a command, its mode, true for an alarm and for a taken alarm, the faulty channels, the number of
/// faulty samples, and the states: the detection with its ticks, the state, the fault and the acting limits.
type CommandParts = ([f64; 9], u8, (bool, bool), Vec<String>, u32, States);

type States = (u8, u32, u8, u8, Vec<String>);

fn named(names: [&'static str; 4], given: &[String]) -> Vec<&'static str> {
    names.into_iter().filter(|name| given.iter().any(|one| one == name)).collect()
}

fn place(word: &str, words: impl IntoIterator<Item = &'static str>) -> u8 {
    words.into_iter().position(|one| one == word).map_or(0, |place| place as u8)
}

#[pymethods]
impl Command {
    /// Restores a pickled command.
    #[new]
    fn new(
        numbers: [f64; 9],
        mode: u8,
        alarms: (bool, bool),
        faults: Vec<String>,
        faulty_samples: u32,
        states: States,
    ) -> Self {
        let (detection, detection_ticks, state, fault, limited) = states;
        let of_code = |code: u8| usize::from(code);
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
            faults: named(CHANNELS, &faults),
            faulty_samples,
            detection: DetectionState::ALL.get(of_code(detection)).map_or("blind", |state| state.word()),
            detection_ticks,
            state: SafetyState::ALL.get(of_code(state)).map_or("disabled", |state| state.word()),
            fault: FaultCause::ALL.get(of_code(fault).wrapping_sub(1)).map(|cause| cause.word()),
            limited: named(LIMITS, &limited),
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
        let owned = |names: &[&str]| names.iter().map(|name| (*name).to_owned()).collect();
        let fault = self.fault.map_or(0, |fault| 1 + place(fault, FaultCause::ALL.map(FaultCause::word)));
        let states = (
            place(self.detection, DetectionState::ALL.map(DetectionState::word)),
            self.detection_ticks,
            place(self.state, SafetyState::ALL.map(SafetyState::word)),
            fault,
            owned(&self.limited),
        );
        let alarms = (self.alarm, self.alarm_taken);
        (numbers, self.mode, alarms, owned(&self.faults), self.faulty_samples, states)
    }

    fn __repr__(&self) -> String {
        let Self { slave_reference_m, master_force_n, mode, .. } = self;
        format!("Command(slave_reference_m={slave_reference_m:?}, master_force_n={master_force_n:?}, mode={mode}, …)")
    }
}

#[pymethods]
impl HapticController {
    /// The controller of a scenario, with values of the keys `rig.…` and `safety.…`.
    #[new]
    fn new(py: Python<'_>, scenario: &Scenario, changes: Vec<(String, f64)>) -> PyResult<Self> {
        let refuse = |error: ScenarioError| error::scenario(py, &error);
        let key_of = |(path, value): (String, f64)| {
            let is_limit = path.starts_with("rig.") || path.starts_with("safety.");
            let key =
                Settings::KEYS.iter().find(|key| key.path == path && is_limit && matches!(key.kind, Kind::Number(_)));
            let named =
                || error::value(format!("there is no {path}; `trocar.HapticController` lists the keys of a rig"));
            Ok::<_, PyErr>((key.ok_or_else(named)?.path, value))
        };
        let changes = changes.into_iter().map(key_of).collect::<PyResult<Vec<_>>>()?;
        let settings = scenario.scenario.rig_settings_with(&changes).map_err(refuse)?;
        let controller = Box::new(rig::HapticController::new(&settings).map_err(error::value)?);
        Ok(Self { initial: controller.clone(), controller })
    }

    /// Processes a sample. `None` and NaN mark a missing number; `number` is the number of the sample, from 1, if it
    /// has one.
    #[pyo3(signature = (master_position_m, slave_position_m, slave_velocity_m_per_s, force_n, number=None))]
    fn step(
        &mut self,
        master_position_m: Option<f64>,
        slave_position_m: Option<f64>,
        slave_velocity_m_per_s: Option<f64>,
        force_n: Option<f64>,
        number: Option<u64>,
    ) -> Command {
        let sample = Sample {
            master_position_m: master_position_m.unwrap_or(f64::NAN),
            slave_position_m: slave_position_m.unwrap_or(f64::NAN),
            slave_velocity_m_per_s: slave_velocity_m_per_s.unwrap_or(f64::NAN),
            force_n: force_n.unwrap_or(f64::NAN),
        };
        let command = match number {
            None => self.controller.step(&sample),
            Some(number) => self.controller.step_numbered(&sample, number),
        };
        let Faults { master_position, slave_position, slave_velocity, force } = command.faults;
        let faulty = [master_position, slave_position, slave_velocity, force];
        let Limited { force, force_rate, reference_speed, lead } = command.limited;
        let limited = [force, force_rate, reference_speed, lead];
        let of = |names: [&'static str; 4], flags: [bool; 4]| {
            names.into_iter().zip(flags).filter_map(|(name, is_set)| is_set.then_some(name)).collect()
        };
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
            faults: of(CHANNELS, faulty),
            faulty_samples: command.faulty_samples,
            detection: command.detection.word(),
            detection_ticks: command.detection_ticks,
            state: command.state.word(),
            fault: command.fault.map(FaultCause::word),
            limited: of(LIMITS, limited),
        }
    }

    /// Stops until [`HapticController::enable`].
    fn stop(&mut self) {
        self.controller.stop();
    }

    /// Ends a stop or a fault.
    fn enable(&mut self) {
        self.controller.enable();
    }

    /// Returns the names and the values of the counts.
    fn counts(&self) -> Vec<(&'static str, u64)> {
        let Counters { bad, repeated, late, bridged, gaps } = self.controller.counters();
        let safety = self.controller.safety_counts();
        let SafetyCounts { force, force_rate, reference_speed, lead, alignments, faults } = safety;
        vec![
            ("bad", bad),
            ("repeated", repeated),
            ("late", late),
            ("bridged", bridged),
            ("gaps", gaps),
            ("force_limited", force),
            ("force_rate_limited", force_rate),
            ("reference_speed_limited", reference_speed),
            ("lead_limited", lead),
            ("alignments", alignments),
            ("faults", faults),
        ]
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
