//! Conversions between numpy arrays and vectors.

use numpy::{PyArray1, PyArray2, PyReadonlyArray1};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use trocar_base::large_pages::copy_of;

use crate::error;

/// Copies one-dimensional float64 samples, because the array can change while the interpreter's lock is released. The
/// Python code has checked type, shape and layout.
pub(crate) fn samples(array: &PyReadonlyArray1<'_, f64>) -> PyResult<Vec<f64>> {
    Ok(copy_of(array.as_slice().map_err(error::value)?))
}

/// Number of samples above which each array is copied by its own thread: providing the memory takes longer than filling
/// it.
const LONG: usize = 1 << 20;

/// Times, positions, velocities (if measured) and forces.
pub(crate) type RecordingColumns = (Vec<f64>, Vec<f64>, Option<Vec<f64>>, Vec<f64>);

pub(crate) fn recording_columns(
    time_s: &PyReadonlyArray1<'_, f64>,
    position_m: &PyReadonlyArray1<'_, f64>,
    velocity_m_per_s: Option<&PyReadonlyArray1<'_, f64>>,
    force_n: &PyReadonlyArray1<'_, f64>,
) -> PyResult<RecordingColumns> {
    let [mut time, mut position, mut force] = [const { Vec::new() }; 3];
    let mut velocity = velocity_m_per_s.map(|_| Vec::new());
    let required = [(&mut time, time_s), (&mut position, position_m), (&mut force, force_n)];
    let copies = required.into_iter().chain(velocity.as_mut().zip(velocity_m_per_s));
    std::thread::scope(|scope| {
        for (copy, array) in copies {
            let values = array.as_slice().map_err(error::value)?;
            if values.len() < LONG {
                *copy = copy_of(values);
            } else {
                std::thread::Builder::new().spawn_scoped(scope, move || *copy = copy_of(values))?;
            }
        }
        Ok::<_, PyErr>(())
    })?;
    Ok((time, position, velocity, force))
}

pub(crate) fn put<T: numpy::Element>(columns: &Bound<'_, PyDict>, name: &str, values: Vec<T>) -> PyResult<()> {
    columns.set_item(name, PyArray1::from_vec(columns.py(), values))
}

pub(crate) fn matrix<'py>(py: Python<'py>, rows: Vec<Vec<f64>>, columns: usize) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let height = rows.len();
    let flat = PyArray1::from_vec(py, rows.into_iter().flatten().collect());
    numpy::PyArrayMethods::reshape(&flat, [height, columns])
}
