//! Margins and limits of the loop, without a map and without the certificate of events.

use pyo3::prelude::*;
use pyo3::types::PyDict;
use trocar_base::parallel::try_map;
use trocar_stability::{LIMITED, Parameter, Search, largest_stable};
use trocar_studies::stability_check::{CheckError, LoopVerdict};

use crate::error;
use crate::interrupt::interruptible;
use crate::scenario::Scenario;

/// Relative width at which the bisection of a limit ends, and number of scanned values. The scan is coarser than that of
/// the whole analysis, so that all limits take tens of milliseconds.
const TOLERANCE: f64 = 1e-9;
const POINTS: usize = 40;

fn limited(key: &str) -> PyResult<Parameter> {
    Parameter::of_key(key).ok_or_else(|| {
        let known = Parameter::all().map(Parameter::key).collect::<Vec<_>>().join(", ");
        error::value(format!("the loop has no parameter {key:?}; the parameters are {known}"))
    })
}

/// The verdict on the loop of a scenario, with the maximum stable value of each parameter in `limits`.
#[pyfunction]
pub(crate) fn margins<'py>(py: Python<'py>, scenario: &Scenario, limits: Vec<String>) -> PyResult<Bound<'py, PyAny>> {
    let parameters = limits.iter().map(|key| limited(key)).collect::<PyResult<Vec<_>>>()?;
    let scenario = scenario.scenario.clone();
    let judged = interruptible(py, 0, move |_| {
        let verdict = LoopVerdict::of(&scenario)?;
        let limit = |index: usize| {
            let parameter: Parameter = parameters[index];
            let search = Search { tolerance: TOLERANCE, points: POINTS, ..Search::of(parameter) };
            largest_stable(&verdict.settings, parameter, search).map(|limit| (parameter.key(), limit.largest()))
        };
        let limits = try_map(parameters.len(), limit).map_err(CheckError::Stability)?;
        Ok((verdict, limits))
    })?;
    let (verdict, limits) = judged.map_err(|error: CheckError| error::check(py, &error))?;
    let LoopVerdict { settings, mode, margins, .. } = &verdict;
    let of_limits = PyDict::new(py);
    for (key, limit) in limits {
        of_limits.set_item(key, limit)?;
    }
    let all = PyDict::new(py);
    all.set_item("is_stable", verdict.is_stable())?;
    all.set_item("gain", margins.gain)?;
    all.set_item("gain_below", margins.gain_below)?;
    all.set_item("gain_frequency_hz", margins.gain_frequency_hz)?;
    all.set_item("phase_rad", margins.phase_rad)?;
    all.set_item("phase_frequency_hz", margins.phase_frequency_hz)?;
    all.set_item("delay_s", margins.delay_s)?;
    all.set_item("spectral_radius", mode.spectral_radius)?;
    all.set_item("mode_frequency_hz", mode.frequency_hz)?;
    all.set_item("mode_damping_ratio", mode.damping_ratio)?;
    all.set_item("stiffness_n_per_m", settings.stiffness_n_per_m)?;
    all.set_item("damping_n_s_per_m", settings.damping_n_s_per_m)?;
    all.set_item("tissue_n_per_m", settings.tissue.sector_n_per_m())?;
    all.set_item("tissue_n_s_per_m", settings.tissue.springs.damping_n_s_per_m)?;
    all.set_item("left_out", verdict.left_out.iter().map(ToString::to_string).collect::<Vec<_>>())?;
    all.set_item("sentence", error::in_python(&verdict.sentence()))?;
    all.set_item("limits", of_limits)?;
    Ok(all.into_any())
}

/// The keys whose limits [`margins`] computes if none is named.
#[pyfunction]
pub(crate) fn limited_keys() -> Vec<&'static str> {
    LIMITED.iter().map(|parameter| parameter.key()).collect()
}
