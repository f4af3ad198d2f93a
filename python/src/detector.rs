//! The estimator and the detector for single samples.

use numpy::{PyArray1, PyReadonlyArray1};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use trocar_base::rows::Rows;
use trocar_core::lane::Stored as _;
use trocar_detect::{ASSUMED_STEP_M, DetectionChain, Measurement, VelocitySource};
use trocar_recording::Limits;
use trocar_scenario::{DetectionSettings, Values};

use crate::arrays::{put, samples};
use crate::detect::tuning;
use crate::error;

/// Number of samples between two checks for signals; they take some milliseconds.
const SAMPLES_BETWEEN_CHECKS: usize = 1 << 16;

/// The results of one sample, returned by `Detector.step`. Setting an attribute raises an `AttributeError`.
///
/// Attributes
/// ----------
/// alarm : bool
///     True if the detector raises an alarm.
/// velocity_m_per_s : float
///     Velocity of the needle, in m/s, as given or estimated.
/// depth_m : float
///     Depth of the needle below the contact position, in m; negative before contact.
/// predicted_force_n, residual_n : float
///     Force predicted by the estimator before this sample, and the measured force minus this prediction, in N.
/// stiffness_n_per_m, damping_n_s_per_m : float
///     Estimated stiffness, in N/m, and damping, in N·s/m.
/// distance, decision : float
///     The distance, and the decision, which raises an alarm above `detector.threshold`. Their units depend on
///     `detector.distance`.
///
/// ```text
/// >>> import trocar
/// >>> step = trocar.Detector(0.001, contact_m=0.012).step(0.013, 0.01, 0.5)
/// >>> step.alarm, step.residual_n
/// (False, 0.5)
///
/// ```
#[pyclass(frozen, get_all, module = "trocar._core")]
pub(crate) struct Step {
    /// True if the detector raises an alarm.
    alarm: bool,
    /// Velocity of the needle, in m/s, as given or estimated.
    velocity_m_per_s: f64,
    /// Depth of the needle below the contact position, in m; negative before contact.
    depth_m: f64,
    /// Force that the estimator predicted before this sample, in N.
    predicted_force_n: f64,
    /// The measured force minus the predicted one, in N.
    residual_n: f64,
    /// Estimated stiffness, in N/m.
    stiffness_n_per_m: f64,
    /// Estimated damping, in N·s/m.
    damping_n_s_per_m: f64,
    /// The distance, whose unit depends on `detector.distance`.
    distance: f64,
    /// The decision, which raises an alarm above `detector.threshold`.
    decision: f64,
}

#[pymethods]
impl Step {
    #[new]
    #[expect(clippy::too_many_arguments, reason = "a step that is unpickled")]
    fn new(
        alarm: bool,
        velocity_m_per_s: f64,
        depth_m: f64,
        predicted_force_n: f64,
        residual_n: f64,
        stiffness_n_per_m: f64,
        damping_n_s_per_m: f64,
        distance: f64,
        decision: f64,
    ) -> Self {
        Self {
            alarm,
            velocity_m_per_s,
            depth_m,
            predicted_force_n,
            residual_n,
            stiffness_n_per_m,
            damping_n_s_per_m,
            distance,
            decision,
        }
    }

    /// The arguments with which [`Step::new`] restores this step.
    fn __getnewargs__(&self) -> (bool, f64, f64, f64, f64, f64, f64, f64, f64) {
        (
            self.alarm,
            self.velocity_m_per_s,
            self.depth_m,
            self.predicted_force_n,
            self.residual_n,
            self.stiffness_n_per_m,
            self.damping_n_s_per_m,
            self.distance,
            self.decision,
        )
    }

    fn __repr__(&self) -> String {
        let Self { alarm, residual_n, decision, .. } = self;
        let alarm = if *alarm { "True" } else { "False" };
        format!("Step(alarm={alarm}, residual_n={residual_n:?}, decision={decision:?}, …)")
    }
}

/// Estimator and detector for single samples.
#[pyclass(module = "trocar._core")]
pub(crate) struct Detector {
    chain: DetectionChain,
    initial: DetectionChain,
    is_filtered: bool,
    samples: u64,
}

#[pymethods]
impl Detector {
    #[new]
    fn new(
        py: Python<'_>,
        interval_s: f64,
        is_filtered: bool,
        settings: Vec<String>,
        settings_file: Option<&str>,
    ) -> PyResult<Self> {
        let refuse = |error| error::scenario(py, &error);
        let mut all = settings_file.map(|file| tuning(py, file)).transpose()?.unwrap_or_default();
        all.extend(settings);
        let mut values = Values::from_settings("detector", &all).map_err(refuse)?.with_adaptive_detector();
        let settings = DetectionSettings::resolve(&mut values).map_err(refuse)?;
        let given = settings.position_resolution_m;
        let velocity = match is_filtered {
            true => VelocitySource::Filtered { step_m: if given > 0.0 { given } else { ASSUMED_STEP_M } },
            false => VelocitySource::Measured,
        };
        let chain = DetectionChain::new(&settings, interval_s, velocity).map_err(|_| {
            error::value(format!("interval_s is {interval_s:?}, must be a positive, finite number of seconds"))
        })?;
        Ok(Self { initial: chain.clone(), chain, is_filtered, samples: 0 })
    }

    /// A detector in the same state.
    fn copy(&self) -> Self {
        Self {
            chain: self.chain.clone(),
            initial: self.initial.clone(),
            is_filtered: self.is_filtered,
            samples: self.samples,
        }
    }

    fn state<'py>(&self, py: Python<'py>) -> (u64, Bound<'py, PyArray1<u64>>) {
        (self.samples, PyArray1::from_vec(py, self.chain.state()))
    }

    /// Restores the state of a detector with the same settings.
    fn restore(&mut self, samples: u64, state: PyReadonlyArray1<'_, u64>) -> PyResult<()> {
        self.chain.restore(state.as_slice().map_err(error::value)?).map_err(error::value)?;
        self.samples = samples;
        Ok(())
    }

    fn reset(&mut self) {
        (self.chain, self.samples) = (self.initial.clone(), 0);
    }

    #[getter]
    fn samples(&self) -> u64 {
        self.samples
    }

    #[getter]
    fn is_filtered(&self) -> bool {
        self.is_filtered
    }

    /// Processes a sample: position in m, velocity in m/s or `None`, force in N.
    fn step(&mut self, position_m: f64, velocity_m_per_s: Option<f64>, force_n: f64) -> PyResult<Step> {
        let velocity_m_per_s = self.velocity(velocity_m_per_s)?;
        let measurement = Measurement { position_m, velocity_m_per_s, force_n };
        check(&measurement, None)?;
        let step = self.chain.step(&measurement);
        self.samples += 1;
        Ok(Step {
            alarm: step.decision.alarm,
            velocity_m_per_s: step.velocity_m_per_s,
            depth_m: step.depth_m,
            predicted_force_n: step.estimate.predicted_force_n,
            residual_n: step.estimate.residual_n,
            stiffness_n_per_m: step.estimate.stiffness_n_per_m,
            damping_n_s_per_m: step.estimate.damping_n_s_per_m,
            distance: step.decision.distance,
            decision: step.decision.decision,
        })
    }

    /// Processes several samples. Processes none of them if one is invalid or if a signal such as Ctrl-C interrupts
    /// the call. Returns the columns and the indices of the samples with an alarm.
    fn steps<'py>(
        &mut self,
        py: Python<'py>,
        position_m: PyReadonlyArray1<'py, f64>,
        velocity_m_per_s: Option<PyReadonlyArray1<'py, f64>>,
        force_n: PyReadonlyArray1<'py, f64>,
    ) -> PyResult<(Bound<'py, PyDict>, Bound<'py, PyArray1<i64>>)> {
        let (position, force) = (samples(&position_m)?, samples(&force_n)?);
        let velocity = velocity_m_per_s.as_ref().map(samples).transpose()?;
        self.velocity(velocity.as_ref().map(|_| 0.0))?;
        let count = position.len();
        for (name, length) in [("velocity", velocity.as_ref().map_or(count, Vec::len)), ("force", force.len())] {
            if length != count {
                return Err(error::value(format!(
                    "{name} has {length} samples and position has {count}; the lengths must be equal"
                )));
            }
        }
        let measurement = |at: usize| Measurement {
            position_m: position[at],
            velocity_m_per_s: velocity.as_ref().map_or(0.0, |velocity| velocity[at]),
            force_n: force[at],
        };
        (0..count).try_for_each(|at| check(&measurement(at), Some(at)))?;
        let mut rows = Rows::new(count, [true; 8]);
        let mut alarms = vec![];
        let mut chain = self.chain.clone();
        py.detach(|| {
            for at in 0..count {
                if at % SAMPLES_BETWEEN_CHECKS == SAMPLES_BETWEEN_CHECKS - 1 {
                    Python::attach(|py| py.check_signals())?;
                }
                let step = chain.step(&measurement(at));
                if step.decision.alarm {
                    alarms.push(at as i64);
                }
                rows.push([
                    step.velocity_m_per_s,
                    step.depth_m,
                    step.estimate.predicted_force_n,
                    step.estimate.residual_n,
                    step.estimate.stiffness_n_per_m,
                    step.estimate.damping_n_s_per_m,
                    step.decision.distance,
                    step.decision.decision,
                ]);
            }
            Ok::<_, PyErr>(())
        })?;
        self.chain = chain;
        self.samples += count as u64;
        let names = [
            "velocity_m_per_s",
            "depth_m",
            "predicted_force_n",
            "residual_n",
            "stiffness_n_per_m",
            "damping_n_s_per_m",
            "distance",
            "decision",
        ];
        let all = PyDict::new(py);
        for (name, column) in names.into_iter().zip(rows.into_columns()) {
            put(&all, name, column)?;
        }
        Ok((all, PyArray1::from_vec(py, alarms)))
    }
}

impl Detector {
    fn velocity(&self, given: Option<f64>) -> PyResult<f64> {
        match (given, self.is_filtered) {
            (Some(velocity), false) => Ok(velocity),
            (None, true) => Ok(0.0),
            (None, false) => {
                Err(error::value("velocity is missing; create the detector with velocity=\"filtered\" to estimate it"))
            }
            (Some(_), true) => Err(error::value("this detector estimates the velocity; pass None")),
        }
    }
}

/// Refuses a sample that would corrupt the estimates permanently.
fn check(measurement: &Measurement<f64>, at: Option<usize>) -> PyResult<()> {
    let all = [
        ("position", measurement.position_m),
        ("velocity", measurement.velocity_m_per_s),
        ("force", measurement.force_n),
    ];
    // False for NaN.
    let is_valid = |value: f64| value.abs() <= Limits::MAX_MAGNITUDE;
    match all.into_iter().find(|(_, value)| !is_valid(*value)) {
        None => Ok(()),
        Some((name, value)) => {
            let at = at.map_or(String::new(), |at| format!("[{at}]"));
            let max = Limits::MAX_MAGNITUDE;
            Err(error::value(format!("{name}{at} is {value}, must be a finite number of at most {max:e} in SI units")))
        }
    }
}
