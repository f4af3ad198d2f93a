//! The compiled half of the Python package `trocar`: scenarios in, numpy arrays out.
//!
//! Everything is computed by the crate [`trocar`]; here are conversions only. The Python half (`trocar/*.py`) gives it the face
//! that users see. Arrays that come out are the vectors that were computed, handed over without a copy; the interpreter's lock
//! is released while anything is computed, and Ctrl-C is looked for meanwhile.

mod arrays;
mod calibrate;
mod compare;
mod convert;
mod detect;
mod detector;
mod error;
mod interrupt;
mod run;
mod scenario;
mod stability;
mod state_space;
mod sweep;

use pyo3::prelude::*;

/// The compiled core of trocar.
#[pymodule(gil_used = true)]
mod _core {
    use pyo3::prelude::*;

    #[pymodule_export]
    use crate::calibrate::calibrate;
    #[pymodule_export]
    use crate::compare::compare;
    #[pymodule_export]
    use crate::convert::toml_value;
    #[pymodule_export]
    use crate::detect::detect;
    #[pymodule_export]
    use crate::detector::{Detector, Step};
    #[pymodule_export]
    use crate::run::{Run, run, seconds_of_run, trace_columns};
    #[pymodule_export]
    use crate::scenario::{Scenario, keys, record, shipped};
    #[pymodule_export]
    use crate::stability::stability;
    #[pymodule_export]
    use crate::state_space::{StateSpace, state_space};
    #[pymodule_export]
    use crate::sweep::{metrics, sweep};

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}
