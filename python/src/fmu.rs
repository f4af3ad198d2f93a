//! Functional mock-up units.

use pyo3::exceptions::PyOSError;
use pyo3::prelude::*;
use trocar_studies::fmu::{Model, Unit, UnitError, Version};

use crate::error;
use crate::scenario::{Scenario, named};

/// The files of a unit with their paths in its archive, without the licences.
#[pyfunction]
pub(crate) fn fmu_files(
    py: Python<'_>,
    scenario: &Scenario,
    model: &str,
    fmi: u32,
    library: Vec<u8>,
) -> PyResult<Vec<(String, Vec<u8>)>> {
    let model = match model {
        "simulation" => Model::Simulation,
        "rig" => Model::Rig,
        "tissue" => Model::Tissue,
        _ => return Err(error::value(format!("model is {model:?}, must be \"simulation\", \"rig\" or \"tissue\""))),
    };
    let version = match fmi {
        2 => Version::Two,
        3 => Version::Three,
        _ => return Err(error::value(format!("fmi is {fmi}, must be 2 or 3"))),
    };
    if !scenario.recordings.is_empty() {
        return Err(error::value(
            "a unit cannot contain a recording from memory: save it, and name the file in recording.file",
        ));
    }
    let lists: Vec<&[String]> = scenario.settings.iter().map(Vec::as_slice).collect();
    let unit = py.detach(|| Unit::of_changed(&scenario.source, &lists, (model, version), library));
    match unit {
        Ok(unit) => Ok(unit.files),
        Err(UnitError::Scenario(failed)) => Err(error::scenario(py, &named(failed, &scenario.source))),
        Err(failed @ UnitError::File { .. }) => Err(PyOSError::new_err(failed.to_string())),
        Err(failed @ UnitError::Rig(_)) => Err(error::value(failed)),
    }
}

/// The licences of the library, one of which a user may choose: name and text.
#[pyfunction]
pub(crate) fn licences() -> [(&'static str, &'static str); 2] {
    [("LICENSE-MIT", include_str!("../LICENSE-MIT")), ("LICENSE-APACHE", include_str!("../LICENSE-APACHE"))]
}
