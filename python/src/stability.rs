//! Where the loop is stable.

use pyo3::prelude::*;
use pyo3::types::PyDict;
use trocar::report::{stability_json, stability_text};
use trocar::stability::{Analysis, Axis, LoopSettings, Switching, SwitchingSettings, map};
use trocar::stability_check::{CheckError, Verdict, check};

use crate::arrays::put;
use crate::interrupt::interruptible;
use crate::scenario::Scenario;
use crate::{convert, error};

/// The stiffest tissue that events are looked at on, in N/m, as on the command line.
const MOST_STIFFNESS_N_PER_M: f64 = 1e6;

type Analysed<'py> = (Bound<'py, PyAny>, String, Bound<'py, PyDict>);

/// Analyses the loop of a scenario and maps it over two axes: what `stability.json` holds, the text, and arrays: `x`, `y`,
/// `stable` (by rows, from the lowest y), `boundary` (four numbers a piece), `simulated` where that was asked for.
#[pyfunction]
pub(crate) fn stability<'py>(
    py: Python<'py>,
    scenario: &Scenario,
    x: &str,
    y: &str,
    tissue: (f64, f64),
    simulate: bool,
) -> PyResult<Analysed<'py>> {
    let axis = |text: &str| Axis::parse(text).map_err(|reason| error::value(format!("{text}: {reason}")));
    let (x_axis, y_axis) = (axis(x)?, axis(y)?);
    if x_axis.parameter.varies_with(y_axis.parameter) {
        return Err(error::value(format!("{y}: varies what {x} varies; name two parameters that differ")));
    }
    let (low, high) = tissue;
    if !(0.0 <= low && low <= high && high <= MOST_STIFFNESS_N_PER_M) {
        let must = format!("two stiffnesses in N/m, the lesser first, from 0 to {MOST_STIFFNESS_N_PER_M}");
        return Err(error::value(format!("tissue is ({low:?}, {high:?}), must be {must}")));
    }
    let scenario = scenario.scenario.clone();
    let (name, left_out) = (scenario.name.clone(), LoopSettings::left_out(&scenario));
    let analysed = interruptible(py, 0, move |stop| {
        let settings = LoopSettings::of(&scenario);
        let analysis = Analysis::of(&settings)?;
        let map = map(&settings, x_axis, y_axis)?;
        let switching = match SwitchingSettings::of(&scenario, tissue) {
            Ok(settings) => Ok(Switching::of(&settings)?),
            Err(reason) => Err(reason),
        };
        let check = simulate.then(|| check((&scenario, &settings), &map, stop, || ())).transpose()?;
        Ok((analysis, map, switching, check))
    })?;
    let (analysis, map, switching, check) = analysed.map_err(|error: CheckError| error::check(py, &error))?;
    let switching = switching.as_ref().map_err(|reason| *reason);
    let json = convert::parsed(py, &stability_json((&name, &left_out), &analysis, &map, switching, check.as_ref()))?;
    let text = stability_text((&name, &left_out), &analysis, &map, switching, check.as_ref());
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
    Ok((json, text, columns))
}
