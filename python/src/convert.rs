//! Conversions between Python objects, JSON and TOML.

use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyFloat, PyInt, PyList, PyString, PyTuple};
use serde_json::Value as Json;

/// A JSON value as a Python object; `null` is `None`.
pub(crate) fn python<'py>(py: Python<'py>, json: &Json) -> PyResult<Bound<'py, PyAny>> {
    Ok(match json {
        Json::Null => py.None().into_bound(py),
        Json::Bool(flag) => PyBool::new(py, *flag).to_owned().into_any(),
        Json::Number(number) => match (number.as_u64(), number.as_i64()) {
            (Some(whole), _) => whole.into_pyobject(py)?.into_any(),
            (None, Some(whole)) => whole.into_pyobject(py)?.into_any(),
            (None, None) => PyFloat::new(py, number.as_f64().unwrap_or(f64::NAN)).into_any(),
        },
        Json::String(text) => PyString::new(py, text).into_any(),
        Json::Array(values) => {
            let values = values.iter().map(|value| python(py, value)).collect::<PyResult<Vec<_>>>()?;
            PyList::new(py, values)?.into_any()
        }
        Json::Object(entries) => {
            let all = PyDict::new(py);
            for (key, value) in entries {
                all.set_item(key, python(py, value)?)?;
            }
            all.into_any()
        }
    })
}

/// A JSON document of the crate as a Python object.
pub(crate) fn parsed<'py>(py: Python<'py>, json: &str) -> PyResult<Bound<'py, PyAny>> {
    // Python's JSON reader keeps every bit of a number.
    py.import("json")?.call_method1("loads", (json,))
}

#[pyfunction]
pub(crate) fn toml_value(value: &Bound<'_, PyAny>) -> PyResult<String> {
    Ok(toml(value, 0)?.to_string())
}

/// Maximum nesting of a value.
const MAX_DEPTH: usize = 16;

fn toml(value: &Bound<'_, PyAny>, depth: usize) -> PyResult<toml::Value> {
    if depth > MAX_DEPTH {
        return Err(PyValueError::new_err(format!("the nesting of a value is deeper than {MAX_DEPTH}")));
    }
    if let Ok(flag) = value.cast::<PyBool>() {
        return Ok(toml::Value::Boolean(flag.is_true()));
    }
    if value.is_instance_of::<PyInt>() {
        return Ok(toml::Value::Integer(value.extract()?));
    }
    if value.is_instance_of::<PyFloat>() {
        return Ok(toml::Value::Float(value.extract()?));
    }
    if let Ok(text) = value.cast::<PyString>() {
        return Ok(toml::Value::String(text.to_str()?.to_owned()));
    }
    if let Ok(entries) = value.cast::<PyDict>() {
        let mut table = toml::Table::new();
        for (key, value) in entries {
            table.insert(key.extract()?, toml(&value, depth + 1)?);
        }
        return Ok(toml::Value::Table(table));
    }
    if value.is_instance_of::<PyList>() || value.is_instance_of::<PyTuple>() {
        let values = value.try_iter()?.map(|value| toml(&value?, depth + 1)).collect::<PyResult<_>>()?;
        return Ok(toml::Value::Array(values));
    }
    // Handles numpy's arrays and numbers, and paths.
    for method in ["tolist", "__fspath__"] {
        if value.hasattr(method)? {
            return toml(&value.call_method0(method)?, depth + 1);
        }
    }
    let kind = value.get_type().qualname()?;
    Err(PyTypeError::new_err(format!(
        "a value of the type {kind}, must be a number, a string, a boolean or a list of them"
    )))
}
