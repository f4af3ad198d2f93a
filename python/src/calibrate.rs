//! Calibration.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use numpy::PyReadonlyArray1;
use pyo3::prelude::*;
use trocar_detect::calibration::{self, CalibrationRequest};
use trocar_detect::recorded_warnings;
use trocar_scenario::{Reader, Values, keys_without_effect};

use crate::arrays::recording_columns;
use crate::detect::{Refusal, Samples};
use crate::interrupt::interruptible_with_progress;
use crate::{convert, document, error};

/// Calls `tell` with the numbers of completed and of all steps. Returns the content of `calibration.json`, the
/// document, and the settings as TOML.
#[pyfunction]
#[pyo3(signature = (
    name, time_s, position_m, velocity_m_per_s, force_n, settings, *, first_s, quiet_s, keeps_contact, false_alarm_s,
    slowest_rupture_s, fastest_harmless_s, variance_ratio, threads, tell
))]
#[expect(clippy::too_many_arguments, reason = "the Python wrapper passes them by name")]
pub(crate) fn calibrate<'py>(
    py: Python<'py>,
    name: &str,
    time_s: PyReadonlyArray1<'py, f64>,
    position_m: PyReadonlyArray1<'py, f64>,
    velocity_m_per_s: Option<PyReadonlyArray1<'py, f64>>,
    force_n: PyReadonlyArray1<'py, f64>,
    settings: Vec<String>,
    first_s: Option<f64>,
    quiet_s: Option<(f64, f64)>,
    keeps_contact: bool,
    false_alarm_s: Option<f64>,
    slowest_rupture_s: Option<f64>,
    fastest_harmless_s: Option<f64>,
    variance_ratio: Option<f64>,
    threads: usize,
    tell: Option<Py<PyAny>>,
) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyAny>, String)> {
    let default = CalibrationRequest::default();
    let request = CalibrationRequest {
        first_s: first_s.unwrap_or(default.first_s),
        quiet_s,
        keeps_contact,
        false_alarm_s: false_alarm_s.unwrap_or(default.false_alarm_s),
        slowest_rupture_s: slowest_rupture_s.unwrap_or(default.slowest_rupture_s),
        fastest_harmless_s: fastest_harmless_s.unwrap_or(default.fastest_harmless_s),
        variance_ratio: variance_ratio.unwrap_or(default.variance_ratio),
    };
    let samples = Samples(recording_columns(&time_s, &position_m, velocity_m_per_s.as_ref(), &force_n)?);
    let values = Values::from_settings(name, &settings).map_err(|error| error::scenario(py, &error))?;
    let steps = Arc::new([const { AtomicUsize::new(0) }; 2]);
    let counted = steps.clone();
    let tell = |py: Python<'_>| {
        let [done, all] = counted.each_ref().map(|count| count.load(Ordering::Relaxed));
        tell.as_ref().filter(|_| all > 0).map_or(Ok(()), |tell| tell.call1(py, (done, all)).map(drop))
    };
    let calibrated = interruptible_with_progress(py, threads, tell, move |_| {
        let (spec, values) = samples.spec(values)?;
        let recording = &spec.recording.recording;
        let mut more = keys_without_effect(&values, &settings, Reader::Calibration);
        more.extend(recorded_warnings(recording.median_interval_s(), recording.position_m(), recording.force_n()));
        let count = |done, all| {
            steps[0].store(done, Ordering::Relaxed);
            steps[1].store(all, Ordering::Relaxed);
        };
        Ok::<_, Refusal>((calibration::calibrate_with_progress(&spec, &request, &count), more))
    })?;
    tell(py)?;
    let (calibration, more) = calibrated.map_err(|refusal| refusal.raise(py))?;
    let calibration = calibration.map_err(error::value)?;
    let mut document = calibration.document(name);
    document.warnings.splice(0..0, more);
    document.json["warnings"] = serde_json::json!(document.warnings);
    Ok((convert::python(py, &document.json)?, document::dictionary(py, &document, false)?, calibration.toml()))
}
