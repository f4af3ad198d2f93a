//! The estimator and the detector on arrays.

use numpy::{PyArray1, PyReadonlyArray1};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use trocar_core::error::InvalidValue;
use trocar_detect::document::{add_timeline, report_document};
use trocar_detect::{DetectionReport, detect_recording};
use trocar_recording::ArrayError;
use trocar_scenario::{DetectionSpec, Reader, ScenarioError, Source, Values, keys_without_effect};

use crate::arrays::{RecordingColumns, put, recording_columns};
use crate::interrupt::interruptible;
use crate::recording::Recording;
use crate::{convert, document, error};

pub(crate) struct Samples(pub(crate) RecordingColumns);

impl Samples {
    pub(crate) fn kept(recording: &Recording) -> Self {
        Self(recording.samples().clone().into_columns())
    }

    /// The specification of the detection and its values. Reads every sample; needs no interpreter.
    pub(crate) fn spec(self, mut values: Values) -> Result<(DetectionSpec, Values), Refusal> {
        let max_gap_s = match values.get("recording.max_gap_s") {
            Some(trocar_scenario::Value::Number(gap_s)) => Some(*gap_s),
            _ => None,
        };
        let (time_s, position_m, velocity_m_per_s, force_n) = self.0;
        let recording = trocar_recording::Recording::new(time_s, position_m, velocity_m_per_s, force_n, max_gap_s)
            .map_err(Refusal::Samples)?;
        let spec = DetectionSpec::of(&mut values, recording).map_err(Refusal::Scenario)?;
        Ok((spec, values))
    }
}

/// The reason for refusing samples.
pub(crate) enum Refusal {
    Samples(ArrayError),
    Scenario(ScenarioError),
    Value(InvalidValue),
}

impl Refusal {
    pub(crate) fn raise(&self, py: Python<'_>) -> PyErr {
        match self {
            Self::Samples(error) => error::value(error),
            Self::Scenario(error) => error::scenario(py, error),
            Self::Value(error) => error::value(error),
        }
    }
}

pub(crate) fn tuning(py: Python<'_>, file: &str) -> PyResult<Vec<String>> {
    const SECTIONS: [&str; 2] = ["estimator", "detector"];
    let values = Values::load(&Source::parse(file), &[]).map_err(|error| error::scenario(py, &error))?;
    if SECTIONS.iter().all(|section| values.section_place(section).is_none()) {
        return Err(error::value(format!("{file}: neither [estimator] nor [detector] in it")));
    }
    Ok(values.written_settings(&SECTIONS))
}

type Detected<'py> = (Bound<'py, PyDict>, Bound<'py, PyArray1<i64>>, bool, Bound<'py, PyAny>, Bound<'py, PyAny>);

/// The columns of `detection.csv`, the rows with an alarm, true if the samples were resampled, the content of
/// `detection.json`, and the document without the figures that show every sample.
#[pyfunction]
#[pyo3(signature = (name, time_s, position_m, velocity_m_per_s, force_n, settings, settings_file))]
#[expect(clippy::too_many_arguments, reason = "the Python wrapper passes them by name")]
pub(crate) fn detect<'py>(
    py: Python<'py>,
    name: &str,
    time_s: PyReadonlyArray1<'py, f64>,
    position_m: PyReadonlyArray1<'py, f64>,
    velocity_m_per_s: Option<PyReadonlyArray1<'py, f64>>,
    force_n: PyReadonlyArray1<'py, f64>,
    settings: Vec<String>,
    settings_file: Option<&str>,
) -> PyResult<Detected<'py>> {
    let mut all = settings_file.map(|file| tuning(py, file)).transpose()?.unwrap_or_default();
    let given = settings.clone();
    all.extend(settings);
    let samples = Samples(recording_columns(&time_s, &position_m, velocity_m_per_s.as_ref(), &force_n)?);
    let values = Values::from_settings(name, &all).map_err(|error| error::scenario(py, &error))?;
    let (detection, report, values) = interruptible(py, 2, move |_| {
        let (spec, values) = samples.spec(values.with_adaptive_detector())?;
        let ruptures_s = spec.recording.ruptures_s;
        let detection = detect_recording(spec.recording.recording, &spec.settings).map_err(Refusal::Value)?;
        let mut report = DetectionReport::of(&detection, &ruptures_s);
        report.warnings.splice(0..0, keys_without_effect(&values, &given, Reader::Detection));
        Ok::<_, Refusal>((detection, report, values))
    })?
    .map_err(|refusal| refusal.raise(py))?;
    let mut document = report_document(name, &report, &values);
    add_timeline(&mut document, values.name(), &report);
    let (json, contents) = (convert::python(py, &document.json)?, document::dictionary(py, &document, false)?);
    let columns = PyDict::new(py);
    put(&columns, "time_s", detection.time_s)?;
    put(&columns, "position_m", detection.position_m)?;
    put(&columns, "velocity_m_per_s", detection.velocity_m_per_s)?;
    put(&columns, "measured_force_n", detection.measured_force_n)?;
    put(&columns, "residual_n", detection.residual_n)?;
    put(&columns, "stiffness_n_per_m", detection.stiffness_n_per_m)?;
    put(&columns, "damping_n_s_per_m", detection.damping_n_s_per_m)?;
    put(&columns, "distance", detection.distance)?;
    put(&columns, "decision", detection.decision)?;
    if let Some((name, values)) = detection.extra_parameter {
        put(&columns, name, values)?;
    }
    let alarms = detection.alarms.into_iter().map(|sample| sample as i64).collect();
    Ok((columns, PyArray1::from_vec(py, alarms), detection.is_resampled, json, contents))
}
