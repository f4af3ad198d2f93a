//! Stability analysis.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use pyo3::prelude::*;
use pyo3::types::PyDict;
use trocar_document::Study as _;
use trocar_stability::Axis;
use trocar_studies::stability_check::{CheckError, MAX_STIFFNESS_N_PER_M, StabilityStudy, Verdict, is_tissue, verify};

use crate::arrays::put;
use crate::interrupt::interruptible_with_progress;
use crate::scenario::Scenario;
use crate::{convert, document, error};

type Analysed<'py> = (Bound<'py, PyAny>, Bound<'py, PyAny>, Bound<'py, PyDict>);

/// The verified certificates of the text of `certificate.json`: names and numbers of conditions.
#[pyfunction]
pub(crate) fn verify_certificate(py: Python<'_>, text: &str) -> PyResult<Vec<(String, u64)>> {
    let all = py.detach(|| verify(text)).map_err(|error| error::value(error.to_string()))?;
    Ok(all.into_iter().map(|one| (one.name, one.conditions)).collect())
}

/// Calls `tell` with the numbers of simulated and of all points.
///
/// The content of `stability.json`, the document, and arrays: `x`, `y`, `stable` (by rows, from the lowest
/// y), `boundary` (four numbers per segment), and `simulated` if requested.
#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "the Python wrapper passes them by name")]
pub(crate) fn stability<'py>(
    py: Python<'py>,
    scenario: &Scenario,
    x: &str,
    y: &str,
    tissue: Option<(f64, f64)>,
    simulate: bool,
    event_limits: bool,
    threads: usize,
    tell: Option<Py<PyAny>>,
) -> PyResult<Analysed<'py>> {
    let axis = |text: &str| Axis::parse(text).map_err(|reason| error::value(format!("{text}: {reason}")));
    let (x_axis, y_axis) = (axis(x)?, axis(y)?);
    if x_axis.parameter.varies_with(y_axis.parameter) {
        return Err(error::value(format!("{y}: varies the same parameter as {x}; name two different parameters")));
    }
    if let Some((low, high)) = tissue.filter(|range| !is_tissue(*range)) {
        let must = format!("two stiffnesses in N/m in ascending order, from 0 to {MAX_STIFFNESS_N_PER_M}");
        return Err(error::value(format!("tissue is ({low:?}, {high:?}), must be {must}")));
    }
    let scenario = scenario.scenario.clone();
    let all = x_axis.count * y_axis.count;
    let done = Arc::new(AtomicUsize::new(0));
    let counted = done.clone();
    let tell = |py: Python<'_>| {
        let done = counted.load(Ordering::Relaxed);
        tell.as_ref().filter(|_| simulate).map_or(Ok(()), |tell| tell.call1(py, (done, all)).map(drop))
    };
    let studied = interruptible_with_progress(py, threads, tell, move |stop| {
        let mut study = StabilityStudy::of(&scenario, (x_axis, y_axis), tissue)?;
        if simulate {
            let count = || {
                done.fetch_add(1, Ordering::Relaxed);
            };
            study.simulate(&scenario, stop, count)?;
        }
        if event_limits {
            study.compute_event_limits()?;
        }
        Ok(study)
    })?;
    tell(py)?;
    let study = studied.map_err(|error: CheckError| error::check(py, &error))?;
    let document = study.document();
    let json = convert::parsed(py, &document.json.to_string())?;
    let contents = document::dictionary(py, &document, false)?;
    drop(document);
    let StabilityStudy { map, check, .. } = study;
    let columns = PyDict::new(py);
    put(&columns, "x", (0..map.x.count).map(|index| map.x.value(index)).collect())?;
    put(&columns, "y", (0..map.y.count).map(|index| map.y.value(index)).collect())?;
    put(&columns, "stable", map.stable)?;
    put(&columns, "boundary", map.boundary.iter().flat_map(|[(a, b), (c, d)]| [*a, *b, *c, *d]).collect::<Vec<f64>>())?;
    if let Some(check) = check {
        let code = |verdict: Option<Verdict>| match verdict {
            Some(Verdict::Decays) => 1,
            Some(Verdict::Grows) => 0,
            Some(Verdict::Undecided) | None => -1,
        };
        put(&columns, "simulated", check.simulated.into_iter().map(code).collect::<Vec<i8>>())?;
    }
    Ok((json, contents, columns))
}
