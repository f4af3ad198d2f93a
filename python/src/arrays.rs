//! Conversions between numpy arrays and vectors.

use numpy::{PyArray1, PyArray2, PyReadonlyArray1};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use trocar_sim::large_pages::copy_of;

use crate::error;

/// Returns a copy of one-dimensional float64 samples, because the array can change while the lock is released. The Python code has
/// checked the type, the shape and the layout.
pub(crate) fn samples(array: &PyReadonlyArray1<'_, f64>) -> PyResult<Vec<f64>> {
    Ok(copy_of(array.as_slice().map_err(error::value)?))
}

/// Number of samples from which arrays are copied by a thread each: to give a copy its memory takes the system longer than to fill it.
const LONG: usize = 1 << 20;

/// Returns copies of several arrays, as those of [`samples`].
pub(crate) fn all_samples<const N: usize>(arrays: [&PyReadonlyArray1<'_, f64>; N]) -> PyResult<[Vec<f64>; N]> {
    let mut copies = [const { Vec::new() }; N];
    std::thread::scope(|scope| {
        for (copy, array) in copies.iter_mut().zip(arrays) {
            let values = array.as_slice().map_err(error::value)?;
            if values.len() < LONG {
                *copy = copy_of(values);
            } else {
                std::thread::Builder::new().spawn_scoped(scope, move || *copy = copy_of(values))?;
            }
        }
        Ok::<_, PyErr>(())
    })?;
    Ok(copies)
}

/// Inserts a vector into a dictionary as an array, without a copy.
pub(crate) fn put<T: numpy::Element>(columns: &Bound<'_, PyDict>, name: &str, values: Vec<T>) -> PyResult<()> {
    columns.set_item(name, PyArray1::from_vec(columns.py(), values))
}

/// Returns a row-major matrix as an array of shape (rows, columns).
pub(crate) fn matrix<'py>(py: Python<'py>, rows: Vec<Vec<f64>>, columns: usize) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let height = rows.len();
    let flat = PyArray1::from_vec(py, rows.into_iter().flatten().collect());
    numpy::PyArrayMethods::reshape(&flat, [height, columns])
}
