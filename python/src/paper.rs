//! The reproduced figures of the paper.

use pyo3::prelude::*;
use trocar_document::Study as _;
use trocar_document::to_json;
use trocar_studies::compare::PaperStudy;
use trocar_studies::run::RunError;

use crate::interrupt::interruptible;
use crate::{convert, document, error};

/// The content of the command line's JSON file, and the document.
#[pyfunction]
pub(crate) fn paper(py: Python<'_>, threads: usize) -> PyResult<(Bound<'_, PyAny>, Bound<'_, PyAny>)> {
    let studied = interruptible(py, threads, |_| {
        let study = PaperStudy::new()?;
        let document = study.document();
        Ok((to_json(&document.json), document::contents(&document, false)))
    })?;
    let (json, contents) = studied.map_err(|error: RunError| error::run(py, &error))?;
    Ok((convert::parsed(py, &json)?, convert::python(py, &contents)?))
}
