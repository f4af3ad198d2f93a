//! Strategies against a rupture, and passivity schemes.

use std::sync::atomic::Ordering;

use pyo3::prelude::*;
use trocar_document::Study as _;
use trocar_document::to_json;
use trocar_scenario::Source;
use trocar_studies::compare::{
    FIXED_PERSONS, MAX_SEEDS, PERSONS, Person, SchemeReport, SchemeStudy, SeedStudy, StrategyOptions, StrategyStudy,
};
use trocar_studies::run::RunError;

use crate::compare::{Compared, handed_over};
use crate::interrupt::interruptible_with_count;
use crate::scenario::Scenario;
use crate::{convert, document, error};

/// A scenario, or the path of a sweep file whose points are the patients.
#[derive(FromPyObject)]
pub(crate) enum Studied<'py> {
    Scenario(PyRef<'py, Scenario>),
    Path(String),
}

impl Studied<'_> {
    /// The source, its settings, and what keeps the recordings in memory that the settings name.
    fn parts(&self) -> (Source, Vec<String>, Vec<crate::recording::Recording>) {
        match self {
            Self::Scenario(scenario) => {
                (scenario.source.clone(), scenario.settings.concat(), scenario.recordings.clone())
            }
            Self::Path(path) => (Source::parse(path), vec![], vec![]),
        }
    }
}

/// The content of `strategies.json`, and the document. Calls `tell` with the number of completed runs.
#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "the Python wrapper passes them by name")]
pub(crate) fn strategies<'py>(
    py: Python<'py>,
    studied: Studied<'py>,
    settings: Vec<String>,
    persons: Vec<String>,
    patients: u64,
    seeds: u64,
    threads: usize,
    tell: Option<Py<PyAny>>,
) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyAny>)> {
    if !(2..=MAX_SEEDS).contains(&seeds) {
        return Err(error::value(format!("seeds is {seeds}, must be from 2 to {MAX_SEEDS}")));
    }
    let person = |name: &String| {
        Person::named(name).ok_or_else(|| {
            let known = PERSONS.map(|person| person.name).join(", ");
            error::value(format!("there is no person {name:?}; the persons are {known}"))
        })
    };
    let chosen = persons.iter().map(person).collect::<PyResult<Vec<_>>>()?;
    let persons = if chosen.is_empty() { FIXED_PERSONS.to_vec() } else { chosen };
    let options = StrategyOptions { persons, patients, seeds };
    let (source, mut all, recordings) = studied.parts();
    all.extend(settings);
    let studied = interruptible_with_count(py, threads, told(tell), move |counted| {
        let _held = recordings;
        let count = |runs| {
            counted.fetch_add(runs, Ordering::Relaxed);
        };
        StrategyStudy::of(&source, &all, &options, count).map(|study| {
            let document = study.document();
            (to_json(&document.json), document::contents(&document, false))
        })
    })?;
    let (json, contents) = studied.map_err(|error: RunError| error::run(py, &error))?;
    Ok((convert::parsed(py, &json)?, convert::python(py, &contents)?))
}

/// Calls `tell`, if there is one, with a number of runs.
fn told(tell: Option<Py<PyAny>>) -> impl Fn(Python<'_>, u64) -> PyResult<()> + Send + Sync {
    move |py, done| tell.as_ref().map_or(Ok(()), |tell| tell.call1(py, (done,)).map(drop))
}

/// The persons and groups of people, each with its meaning.
#[pyfunction]
pub(crate) fn persons() -> Vec<(&'static str, &'static str)> {
    PERSONS.iter().map(|person| (person.name, person.meaning)).collect()
}

/// A scenario with every passivity scheme that its architecture allows, as [`crate::compare::compare`]; the last value
/// is the scenario of each run as TOML.
#[pyfunction]
pub(crate) fn compare_schemes<'py>(
    py: Python<'py>,
    scenario: &Scenario,
    seeds: Option<u64>,
    threads: usize,
    tell: Option<Py<PyAny>>,
) -> PyResult<(Compared<'py>, Vec<String>)> {
    if let Some(seeds) = seeds.filter(|seeds| !(2..=MAX_SEEDS).contains(seeds)) {
        return Err(error::value(format!("seeds is {seeds}, must be from 2 to {MAX_SEEDS}")));
    }
    let (source, settings, recordings) =
        (scenario.source.clone(), scenario.settings.concat(), scenario.recordings.clone());
    let studied = interruptible_with_count(py, threads, told(tell), move |counted| {
        let _held = recordings;
        let study = SchemeStudy::of(&source, &settings)?;
        let scenarios: Vec<_> = study.comparison.runs.iter().map(|run| run.scenario.clone()).collect();
        let count = || {
            counted.fetch_add(1, Ordering::Relaxed);
        };
        let seeds = seeds.map(|seeds| SeedStudy::of(&scenarios, seeds, count)).transpose()?;
        Ok((study, seeds))
    })?;
    let (study, seeds) = studied.map_err(|error: RunError| error::run(py, &error))?;
    let report = SchemeReport { study: &study, seeds: seeds.as_ref() };
    let mut document = report.document();
    document.figures.clear();
    let (json, contents) = (to_json(&document.json), document::dictionary(py, &document, false)?);
    drop(document);
    let scenarios = study.comparison.runs.iter().map(|run| run.scenario.echo()).collect();
    Ok((handed_over(py, &json, contents, study.comparison)?, scenarios))
}
