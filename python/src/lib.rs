//! The compiled part of the Python package `trocar`.
//!
//! The crate [`trocar`] does all computations; this crate converts inputs and results. `trocar/*.py` is the public
//! interface. Returned arrays own the computed vectors, without a copy. Computations release the interpreter's lock
//! and check for Ctrl-C.

mod arrays;
mod arrow;
mod calibrate;
mod compare;
mod convert;
mod design;
mod detect;
mod detector;
mod document;
mod error;
mod figures;
mod fmu;
mod identify;
mod interrupt;
mod margins;
mod paper;
mod points;
mod recording;
mod rig;
mod roc;
mod run;
mod scenario;
mod score;
mod simulation;
mod stability;
mod state_space;
mod strategies;
mod supervised;
mod sweep;
mod user_defined;
mod user_defined_link;

use pyo3::prelude::*;

/// Reuses the memory of freed columns, because new pages take longer than a run's ticks.
#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

/// The compiled core of trocar.
#[pymodule(gil_used = true)]
mod _core {
    use pyo3::prelude::*;

    #[pymodule_export]
    use crate::arrow::arrow_stream;
    #[pymodule_export]
    use crate::calibrate::calibrate;
    #[pymodule_export]
    use crate::compare::compare;
    #[pymodule_export]
    use crate::convert::toml_value;
    #[pymodule_export]
    use crate::design::design;
    #[pymodule_export]
    use crate::detect::detect;
    #[pymodule_export]
    use crate::detector::{Detector, Step};
    #[pymodule_export]
    use crate::error::in_python;
    #[pymodule_export]
    use crate::figures::{comparison_figures, detection_figures, figure_names, run_figure, run_figures};
    #[pymodule_export]
    use crate::fmu::{fmu_files, licences};
    #[pymodule_export]
    use crate::identify::identify;
    #[pymodule_export]
    use crate::margins::{limited_keys, margins};
    #[pymodule_export]
    use crate::paper::paper;
    #[pymodule_export]
    use crate::points::{is_sweep, population, shipped_sweeps, sweep_points};
    #[pymodule_export]
    use crate::recording::{Recording, list_signals, read_recording};
    #[pymodule_export]
    use crate::rig::{Command, HapticController};
    #[pymodule_export]
    use crate::roc::{detectors, record, roc, trial};
    #[pymodule_export]
    use crate::run::{Run, run, run_with, seconds_of_run, trace_columns};
    #[pymodule_export]
    use crate::scenario::{Scenario, keys, shipped};
    #[pymodule_export]
    use crate::score::score;
    #[pymodule_export]
    use crate::simulation::{Simulation, arm_stiffness};
    #[pymodule_export]
    use crate::stability::{stability, verify_certificate};
    #[pymodule_export]
    use crate::state_space::{StateSpace, state_space};
    #[pymodule_export]
    use crate::strategies::{compare_schemes, persons, strategies};
    #[pymodule_export]
    use crate::supervised::{SupervisedRun, advance_all};
    #[pymodule_export]
    use crate::sweep::{metrics, sweep, sweep_document, sweep_plan, sweep_with};

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}
