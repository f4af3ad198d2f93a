//! Comparison of scenarios.

use pyo3::prelude::*;
use pyo3::types::PyDict;
use trocar_report::{all_metrics_text, comparison_json, facts_text, seeds_text};
use trocar_sim::compare::{Comparison, MAX_SEEDS, SeedStudy, paper_facts};

use crate::interrupt::interruptible;
use crate::run::{Run, hand_over};
use crate::scenario::Scenario;
use crate::{convert, error};

type Compared<'py> =
    (Bound<'py, PyAny>, String, Vec<(String, String, &'static str, Vec<Option<f64>>)>, Vec<(Run, Bound<'py, PyDict>)>);

/// Compares scenarios. Returns the content of `comparison.json`, the tables as text, the rows, and the runs.
#[pyfunction]
pub(crate) fn compare<'py>(
    py: Python<'py>,
    scenarios: Vec<PyRef<'py, Scenario>>,
    seeds: Option<u64>,
    is_paper_pair: bool,
) -> PyResult<Compared<'py>> {
    if let Some(seeds) = seeds.filter(|seeds| !(2..=MAX_SEEDS).contains(seeds)) {
        return Err(error::value(format!("seeds is {seeds}, must be from 2 to {MAX_SEEDS}")));
    }
    let scenarios: Vec<_> = scenarios.iter().map(|scenario| scenario.scenario.clone()).collect();
    let compared = interruptible(py, 0, move |_| {
        let study = seeds.map(|seeds| SeedStudy::of(&scenarios, seeds, || ())).transpose()?;
        Ok((Comparison::of(scenarios)?, study))
    })?;
    let (comparison, study) = compared.map_err(|error| error::run(py, &error))?;
    let facts = if is_paper_pair { paper_facts(&comparison) } else { None };
    let json = comparison_json(&comparison, facts.as_deref(), study.as_ref());
    let mut text = all_metrics_text(&comparison);
    let extra = [study.as_ref().map(seeds_text), facts.as_deref().map(facts_text)];
    extra.iter().flatten().for_each(|part| text.push_str(&format!("\n{part}")));
    let rows =
        comparison.table().rows.into_iter().map(|row| (row.metric, row.label, row.unit.si(), row.values)).collect();
    let runs = comparison.runs.into_iter().map(|run| hand_over(py, run)).collect::<PyResult<_>>()?;
    Ok((convert::parsed(py, &json)?, text, rows, runs))
}
