//! Recordings in files and in memory.

use std::ffi::CString;
use std::path::PathBuf;
use std::sync::Arc;

use numpy::{PyArray1, PyReadonlyArray1};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use trocar_core::error::positive;
use trocar_detect::document::signals_document;
use trocar_recording::{Columns, Limits, Quantity};
use trocar_scenario::parse_column;

use crate::arrays::{put, recording_columns};
use crate::{convert, error};

/// A recording in memory. Scenarios can refer to it by name while it is held.
#[pyclass(frozen, module = "trocar._core")]
#[derive(Clone)]
pub(crate) struct Recording {
    name: String,
    recording: Arc<trocar_recording::Recording>,
}

type Arrays<'py> = (
    Bound<'py, PyArray1<f64>>,
    Bound<'py, PyArray1<f64>>,
    Option<Bound<'py, PyArray1<f64>>>,
    Bound<'py, PyArray1<f64>>,
);

#[pymethods]
impl Recording {
    /// Makes a recording of times (s), positions (m), velocities (m/s, if measured) and forces (N). The scenario
    /// limits its gaps.
    #[new]
    fn new(
        time_s: PyReadonlyArray1<'_, f64>,
        position_m: PyReadonlyArray1<'_, f64>,
        velocity_m_per_s: Option<PyReadonlyArray1<'_, f64>>,
        force_n: PyReadonlyArray1<'_, f64>,
    ) -> PyResult<Self> {
        let (time_s, position_m, velocity_m_per_s, force_n) =
            recording_columns(&time_s, &position_m, velocity_m_per_s.as_ref(), &force_n)?;
        let recording =
            trocar_recording::Recording::new(time_s, position_m, velocity_m_per_s, force_n, Some(f64::INFINITY));
        let (name, recording) = trocar_recording::keep(recording.map_err(error::value)?);
        Ok(Self { name, recording })
    }

    /// The arguments with which [`Recording::new`] restores this recording.
    fn __getnewargs__<'py>(&self, py: Python<'py>) -> Arrays<'py> {
        let array = |values: &[f64]| PyArray1::from_slice(py, values);
        let recording = &self.recording;
        (
            array(recording.time_s()),
            array(recording.position_m()),
            recording.velocity_m_per_s().map(array),
            array(recording.force_n()),
        )
    }

    /// The name of the recording, a value of recording.file.
    #[getter]
    fn name(&self) -> &str {
        &self.name
    }
}

impl Recording {
    pub(crate) fn of(recording: Arc<trocar_recording::Recording>) -> Self {
        Self { name: String::new(), recording }
    }

    pub(crate) fn shared(&self) -> Arc<trocar_recording::Recording> {
        self.recording.clone()
    }

    pub(crate) fn samples(&self) -> &trocar_recording::Recording {
        &self.recording
    }
}

/// Lists the signals of a file, like `trocar detect --list --json`.
#[pyfunction]
pub(crate) fn list_signals(py: Python<'_>, path: PathBuf, skip_lines: u64) -> PyResult<Bound<'_, PyAny>> {
    let limits = Limits { skip_lines, ..Limits::default() };
    let signals = trocar_recording::list_signals(&path, &limits).map_err(error::value)?;
    convert::python(py, &signals_document(&path.display().to_string(), &signals).json)
}

#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "Python passes each of them by name")]
pub(crate) fn read_recording<'py>(
    py: Python<'py>,
    path: PathBuf,
    time: &str,
    position: &str,
    velocity: Option<&str>,
    force: &str,
    rate_hz: Option<f64>,
    skip_lines: u64,
    zero_at_start: bool,
) -> PyResult<Bound<'py, PyDict>> {
    if let Some(rate_hz) = rate_hz {
        positive("rate_hz", rate_hz).map_err(error::value)?;
    }
    let column = |text: &str, quantity: Quantity| parse_column(text, quantity.unit()).map_err(error::value);
    let columns = Columns {
        time: column(time, Quantity::Time)?,
        position: column(position, Quantity::Position)?,
        velocity: velocity.map(|velocity| column(velocity, Quantity::Velocity)).transpose()?,
        force: column(force, Quantity::Force)?,
    };
    let limits = Limits { skip_lines, rate_hz, ..Limits::default() };
    let recording = trocar_recording::open_recording(&path, &columns, &limits).map_err(error::value)?;
    let recording = recording.zeroed(zero_at_start);
    for ignored in recording.ignored_units() {
        let (quantity, unit, column) = (ignored.quantity, &ignored.unit, &ignored.with_unit);
        let message = format!(
            "the {} is read in {}, and the file states '{unit}': give {}={column:?}",
            quantity.name(),
            quantity.unit(),
            quantity.name()
        );
        PyErr::warn(py, &py.import("trocar.warnings")?.getattr("UnitIgnoredWarning")?, &CString::new(message)?, 1)?;
    }
    if let Some(reason) = recording.unfinished() {
        let message = CString::new(format!("the recording may be cut off: {reason}"))?;
        PyErr::warn(py, &py.import("trocar.warnings")?.getattr("UnfinishedFileWarning")?, &message, 1)?;
    }
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
