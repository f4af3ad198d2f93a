//! Comparison of scenarios.

use std::sync::atomic::Ordering;

use pyo3::prelude::*;
use pyo3::types::PyDict;
use trocar_base::parallel::try_map;
use trocar_document::Study as _;
use trocar_document::to_json;
use trocar_metrics::Metrics;
use trocar_studies::compare::{Comparison, ComparisonReport, MAX_SEEDS, SeedStudy, paper_facts};
use trocar_studies::run::RunError;

use crate::interrupt::interruptible_with_count;
use crate::run::{Run, hand_over, measure_compiled, measure_with, traced_with};
use crate::scenario::Scenario;
use crate::user_defined::CompiledParts;
use crate::{convert, document, error};

/// The content of `comparison.json`, the document, the rows, and the runs.
pub(crate) type Compared<'py> = (
    Bound<'py, PyAny>,
    Bound<'py, PyAny>,
    Vec<(String, &'static str, Vec<Option<f64>>)>,
    Vec<(Run, Bound<'py, PyDict>)>,
);

/// User-defined parts, by role, run one after the other, or in threads if all are compiled; these runs have no added
/// noise.
///
/// The content of `comparison.json`, the document without its figures, the rows, and the runs. Calls `tell`
/// with the numbers of completed and of all runs of the seeds.
#[pyfunction]
pub(crate) fn compare<'py>(
    py: Python<'py>,
    scenarios: Vec<PyRef<'py, Scenario>>,
    seeds: Option<u64>,
    is_paper_pair: bool,
    threads: usize,
    parts: &Bound<'py, PyDict>,
    tell: Option<Py<PyAny>>,
) -> PyResult<Compared<'py>> {
    if let Some(seeds) = seeds.filter(|seeds| !(2..=MAX_SEEDS).contains(seeds)) {
        return Err(error::value(format!("seeds is {seeds}, must be from 2 to {MAX_SEEDS}")));
    }
    let scenarios: Vec<_> = scenarios.iter().map(|scenario| scenario.scenario.clone()).collect();
    let all = seeds.unwrap_or(0) * scenarios.len() as u64;
    let tell = |py: Python<'_>, done: u64| tell.as_ref().map_or(Ok(()), |tell| tell.call1(py, (done, all)).map(drop));
    let (comparison, study) = if parts.is_empty() {
        let compared = interruptible_with_count(py, threads, tell, move |counted| {
            let count = || {
                counted.fetch_add(1, Ordering::Relaxed);
            };
            let study = seeds.map(|seeds| SeedStudy::of(&scenarios, seeds, count)).transpose()?;
            Ok((Comparison::of(scenarios)?, study))
        })?;
        compared.map_err(|error| error::run(py, &error))?
    } else {
        compare_with(py, &scenarios, seeds, (parts, threads), tell)?
    };
    let facts = if is_paper_pair && parts.is_empty() { paper_facts(&comparison) } else { None };
    let report = ComparisonReport { comparison: &comparison, facts: facts.as_deref(), seeds: study.as_ref() };
    let mut document = report.document();
    // These figures show every sample, so they are described on demand.
    document.figures.clear();
    let (json, contents) = (to_json(&document.json), document::dictionary(py, &document, true)?);
    drop(document);
    handed_over(py, &json, contents, comparison)
}

pub(crate) fn handed_over<'py>(
    py: Python<'py>,
    json: &str,
    contents: Bound<'py, PyAny>,
    comparison: Comparison,
) -> PyResult<Compared<'py>> {
    let rows = comparison.table().rows.into_iter().map(|row| (row.metric, row.unit.si(), row.values)).collect();
    let runs = comparison.runs.into_iter().map(|run| hand_over(py, run)).collect::<PyResult<_>>()?;
    Ok((convert::parsed(py, json)?, contents, rows, runs))
}

fn compare_with(
    py: Python<'_>,
    scenarios: &[trocar_scenario::Scenario],
    seeds: Option<u64>,
    (parts, threads): (&Bound<'_, PyDict>, usize),
    tell: impl Fn(Python<'_>, u64) -> PyResult<()> + Send + Sync,
) -> PyResult<(Comparison, Option<SeedStudy>)> {
    let runs = scenarios.iter().map(|scenario| traced_with(py, scenario, parts)).collect::<PyResult<_>>()?;
    let study = |runs: Vec<Vec<Metrics>>| Some(SeedStudy::of_runs(scenarios, &runs));
    if let (Some(compiled), Some(seeds)) = (CompiledParts::of(parts)?, seeds) {
        let seeded = scenarios.to_vec();
        let measured = interruptible_with_count(py, threads, tell, move |done| {
            try_map(seeds as usize, |offset| {
                let of = |scenario: &trocar_scenario::Scenario| {
                    let seeded = scenario.with_seed(scenario.seed.wrapping_add(offset as u64));
                    let metrics = measure_compiled(&seeded, &compiled);
                    done.fetch_add(1, Ordering::Relaxed);
                    metrics
                };
                seeded.iter().map(of).collect::<PyResult<Vec<_>>>()
            })
        })??;
        let raise = |metrics: Result<Metrics, RunError>| metrics.map_err(|error| error::run(py, &error));
        let runs_of = |seed: Vec<_>| seed.into_iter().map(raise).collect::<PyResult<Vec<_>>>();
        let measured = measured.into_iter().map(runs_of).collect::<PyResult<Vec<_>>>()?;
        return Ok((Comparison { runs, noise: vec![] }, study(measured)));
    }
    let mut done = 0;
    let mut measure = |scenario: &trocar_scenario::Scenario, offset: u64| {
        let seeded = scenario.with_seed(scenario.seed.wrapping_add(offset));
        let metrics = measure_with(py, &seeded, parts)?.map_err(|error| error::run(py, &error))?;
        done += 1;
        tell(py, done)?;
        Ok(metrics)
    };
    let mut of_seed = |offset| scenarios.iter().map(|scenario| measure(scenario, offset)).collect::<PyResult<Vec<_>>>();
    let of_seeds = seeds.map(|seeds| (0..seeds).map(&mut of_seed).collect::<PyResult<Vec<_>>>()).transpose()?;
    Ok((Comparison { runs, noise: vec![] }, of_seeds.and_then(study)))
}
