//! Stability analysis.

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use pyo3::prelude::*;
use pyo3::types::PyDict;
use trocar_document::Study as _;
use trocar_recording::{Limits, open_response};
use trocar_stability::{Axis, FrequencyResponse, MeasuredSides, Terminations};
use trocar_studies::stability_check::{CheckError, MAX_STIFFNESS_N_PER_M, StabilityStudy, Verdict, is_tissue, verify};

use crate::arrays::put;
use crate::interrupt::interruptible_with_progress;
use crate::scenario::Scenario;
use crate::{convert, document, error};

type Analysed<'py> =
    (Bound<'py, PyAny>, Bound<'py, PyAny>, Bound<'py, PyDict>, Vec<(String, String)>, Bound<'py, PyDict>);

/// The verified certificates of the text of `certificate.json` for a scenario: names and numbers of conditions.
#[pyfunction]
pub(crate) fn verify_certificate(
    py: Python<'_>,
    text: &str,
    scenario: &Scenario,
) -> PyResult<Vec<(&'static str, u64)>> {
    let scenario = &scenario.scenario;
    let all = py.detach(|| verify(text, scenario)).map_err(|error| error::value(error.to_string()))?;
    Ok(all.into_iter().map(|one| (one.name, one.conditions)).collect())
}

/// A frequency response: the path of a CSV file, or rows of frequency (Hz), magnitude and phase (rad).
#[derive(FromPyObject)]
pub(crate) enum Response {
    File(PathBuf),
    Rows(Vec<[f64; 3]>),
}

impl Response {
    fn of(given: Option<&Self>, name: &str) -> PyResult<Option<FrequencyResponse>> {
        let response = match given {
            None => return Ok(None),
            Some(Self::Rows(rows)) => FrequencyResponse::new(rows.iter().copied()),
            Some(Self::File(path)) => {
                let rows = open_response(path, &Limits::default()).map_err(error::value)?;
                FrequencyResponse::new(rows.iter().map(|row| [row.frequency_hz, row.magnitude, row.phase_rad]))
            }
        };
        let must = "at least two finite values at ascending frequencies above 0, none of them 0";
        response.map(Some).ok_or_else(|| error::value(format!("{name} must have {must}")))
    }
}

/// What [`stability`] computes besides the map.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct Options {
    tissue: Option<(f64, f64)>,
    tissue_damping: Option<(f64, f64)>,
    hand: Option<(f64, f64)>,
    absolute: Option<String>,
    locus: Option<String>,
    z_width: Option<String>,
    master_response: Option<Response>,
    slave_response: Option<Response>,
    simulate: bool,
    event_limits: bool,
}

const MAX_DAMPING_N_S_PER_M: f64 = 1e6;

fn dampings(name: &str, range: Option<(f64, f64)>, max: f64) -> PyResult<Option<(f64, f64)>> {
    let is_range =
        |(low, high): (f64, f64)| (0.0..=MAX_DAMPING_N_S_PER_M).contains(&low) && (low..=max).contains(&high);
    match range {
        Some((low, high)) if !is_range((low, high)) => {
            let must = format!("two dampings in N·s/m in ascending order, from 0 to {MAX_DAMPING_N_S_PER_M}");
            Err(error::value(format!("{name} is ({low:?}, {high:?}), must be {must}")))
        }
        range => Ok(range),
    }
}

fn axis(name: &str, text: &str) -> PyResult<Axis> {
    Axis::parse(text).map_err(|reason| error::value(format!("{name}: {reason}")))
}

/// Calls `tell` with the numbers of simulated and of all points.
///
/// The content of `stability.json`, the document, arrays, the files with their texts, and the data tables. The arrays
/// are `x`, `y`, `stable` (by rows, from the lowest y), `boundary` (four numbers per segment), and `simulated` if
/// requested.
#[pyfunction]
pub(crate) fn stability<'py>(
    py: Python<'py>,
    scenario: &Scenario,
    x: &str,
    y: &str,
    options: Options,
    threads: usize,
    tell: Option<Py<PyAny>>,
) -> PyResult<Analysed<'py>> {
    let (x_axis, y_axis) = (axis("x", x)?, axis("y", y)?);
    if x_axis.parameter.varies_with(y_axis.parameter) {
        return Err(error::value(format!(
            "y is {y:?} and x is {x:?}: they vary the same parameter; name two different ones"
        )));
    }
    let optional = |name, text: &Option<String>| text.as_ref().map(|text| axis(name, text)).transpose();
    let Options { tissue, simulate, event_limits, .. } = options;
    if let Some((low, high)) = tissue.filter(|range| !is_tissue(*range)) {
        let must = format!("two stiffnesses in N/m in ascending order, from 0 to {MAX_STIFFNESS_N_PER_M}");
        return Err(error::value(format!("tissue is ({low:?}, {high:?}), must be {must}")));
    }
    let of_absolute = optional("absolute", &options.absolute)?;
    let of_locus = optional("locus", &options.locus)?;
    let of_walls = optional("z_width", &options.z_width)?;
    let of_tissue = dampings("tissue_damping", options.tissue_damping, MAX_DAMPING_N_S_PER_M)?;
    let of_hand = dampings("hand", options.hand, f64::INFINITY)?;
    let sides = MeasuredSides {
        master: Response::of(options.master_response.as_ref(), "master_response")?,
        slave: Response::of(options.slave_response.as_ref(), "slave_response")?,
    };
    let source = (scenario.source.clone(), scenario.settings.concat(), scenario.recordings.clone());
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
        if let Some(axis) = &of_walls {
            study.compute_z_width(axis)?;
        }
        if sides.master.is_some() || sides.slave.is_some() {
            study.compute_measured(&sides)?;
        }
        if of_absolute.is_some() || of_tissue.is_some() || of_hand.is_some() {
            let damping_n_s_per_m = of_tissue.unwrap_or(study.bounded.terminations.damping_n_s_per_m);
            let hand_n_s_per_m = of_hand.unwrap_or(study.bounded.terminations.hand_n_s_per_m);
            let terminations = Terminations { hand_n_s_per_m, damping_n_s_per_m, ..study.bounded.terminations };
            study.compute_absolute(&terminations, of_absolute.as_ref())?;
        }
        if simulate {
            let count = || {
                done.fetch_add(1, Ordering::Relaxed);
            };
            study.simulate(&scenario, stop, count)?;
        }
        if event_limits {
            study.compute_event_limits()?;
        }
        if let Some(axis) = &of_locus {
            study.compute_locus(axis)?;
        }
        let (source, settings, _held) = source;
        study.make_worst_events(&source, &settings).map_err(|error| CheckError::Run(error.into()))?;
        Ok(study)
    })?;
    tell(py)?;
    let study = studied.map_err(|error: CheckError| error::check(py, &error))?;
    let document = study.document();
    let json = convert::parsed(py, &document.json.to_string())?;
    let contents = document::dictionary(py, &document, false)?;
    let files = document.files.iter().map(|file| (file.name.to_string(), file.text.clone())).collect();
    let data = document::data(py, &document)?;
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
    Ok((json, contents, columns, files, data))
}
