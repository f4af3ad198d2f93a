//! Recordings in files.

use std::path::PathBuf;

use pyo3::prelude::*;
use pyo3::types::PyDict;
use trocar_report::signals_object;
use trocar_sim::recording::{Columns, Limits, Quantity};
use trocar_sim::scenario::parse_column;

use crate::arrays::put;
use crate::{convert, error};

/// Lists the signals of a file, as `trocar detect --list --json`.
#[pyfunction]
pub(crate) fn list_signals(py: Python<'_>, path: PathBuf) -> PyResult<Bound<'_, PyAny>> {
    let signals = trocar_sim::recording::list_signals(&path, &Limits::default()).map_err(error::value)?;
    convert::python(py, &signals_object(&path.display().to_string(), &signals))
}

/// Reads a recording from a file, in SI units.
#[pyfunction]
pub(crate) fn read_recording<'py>(
    py: Python<'py>,
    path: PathBuf,
    time: &str,
    position: &str,
    velocity: Option<&str>,
    force: &str,
) -> PyResult<Bound<'py, PyDict>> {
    let column = |text: &str, quantity: Quantity| parse_column(text, quantity.unit()).map_err(error::value);
    let columns = Columns {
        time: column(time, Quantity::Time)?,
        position: column(position, Quantity::Position)?,
        velocity: velocity.map(|velocity| column(velocity, Quantity::Velocity)).transpose()?,
        force: column(force, Quantity::Force)?,
    };
    let recording = trocar_sim::recording::open_recording(&path, &columns, &Limits::default()).map_err(error::value)?;
    let arrays = PyDict::new(py);
    put(&arrays, "time", recording.time_s().to_vec())?;
    put(&arrays, "position", recording.position_m().to_vec())?;
    match recording.velocity_m_per_s() {
        Some(velocity) => put(&arrays, "velocity", velocity.to_vec())?,
        None => arrays.set_item("velocity", py.None())?,
    }
    put(&arrays, "force", recording.force_n().to_vec())?;
    Ok(arrays)
}
