//! Scenarios.

use std::sync::Arc;

use pyo3::prelude::*;
use serde_json::Value as Json;
use trocar_sim::scenario::{KEYS, ScenarioError, Source, shipped_questions};

use crate::{convert, error};

/// A scenario that can be run, with what it was made of.
#[pyclass(frozen, module = "trocar._core")]
pub(crate) struct Scenario {
    pub(crate) scenario: trocar_sim::scenario::Scenario,
    pub(crate) source: Source,
    pub(crate) settings: Vec<String>,
}

impl Scenario {
    fn of(py: Python<'_>, source: Source, settings: Vec<String>) -> PyResult<Self> {
        let load = || trocar_sim::scenario::Scenario::load(&source, &settings);
        let scenario = py.detach(load).map_err(|error| error::scenario(py, &named(error, &source)))?;
        Ok(Self { scenario, source, settings })
    }
}

/// The error with the file that it is about, as the command line names it.
pub(crate) fn named(mut error: ScenarioError, source: &Source) -> ScenarioError {
    let file = source.display();
    if error.place.is_none() && !error.message.contains(&file) {
        error.message = format!("{file}: {}", error.message);
    }
    error
}

/// A text as a source.
pub(crate) fn text_source(name: &str, text: &str) -> Source {
    Source::Text { name: name.into(), text: Arc::from(text) }
}

#[pymethods]
impl Scenario {
    /// A file, or `builtin:` and a name.
    #[staticmethod]
    fn load(py: Python<'_>, path: &str, settings: Vec<String>) -> PyResult<Self> {
        Self::of(py, Source::parse(path), settings)
    }

    /// A text as a file would hold it.
    #[staticmethod]
    fn from_text(py: Python<'_>, name: &str, text: &str, settings: Vec<String>) -> PyResult<Self> {
        Self::of(py, text_source(name, text), settings)
    }

    /// The same with further settings, which count before the earlier ones.
    fn replace(&self, py: Python<'_>, settings: Vec<String>) -> PyResult<Self> {
        let settings = self.settings.iter().cloned().chain(settings).collect();
        Self::of(py, self.source.clone(), settings)
    }

    /// What it was made of: the path or none, the name, the text or none, the settings.
    fn origin(&self) -> (Option<String>, String, Option<String>, Vec<String>) {
        let settings = self.settings.clone();
        match &self.source {
            Source::Text { name, text } => (None, name.to_string(), Some(text.to_string()), settings),
            source => (Some(source.canonical().display()), source.stem(), None, settings),
        }
    }

    fn to_toml(&self) -> String {
        self.scenario.echo()
    }

    fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let values: Json = toml::from_str(&self.scenario.echo()).map_err(error::value)?;
        convert::python(py, &values)
    }

    #[getter]
    fn name(&self) -> &str {
        &self.scenario.name
    }

    #[getter]
    fn seed(&self) -> u64 {
        self.scenario.seed
    }

    #[getter]
    fn tick_s(&self) -> f64 {
        self.scenario.grid.tick_s()
    }

    #[getter]
    fn ticks(&self) -> u64 {
        self.scenario.grid.ticks()
    }

    #[getter]
    fn rupture_times_s(&self) -> Vec<f64> {
        self.scenario.rupture_times_s()
    }
}

/// The scenarios that the package carries, each with its question.
#[pyfunction]
pub(crate) fn shipped() -> Vec<(String, &'static str)> {
    shipped_questions().map(|(name, question)| (format!("builtin:{name}"), question)).collect()
}

/// Every key of a scenario: its path, what it holds, its default as TOML writes it or none, its meaning.
#[pyfunction]
pub(crate) fn keys() -> Vec<(&'static str, String, Option<String>, &'static str)> {
    let default = |key: &trocar_sim::scenario::Key| match key.fallback {
        trocar_sim::scenario::Fallback::Value(value) => {
            Some(trocar_sim::scenario::Value::from(value).to_toml().to_string())
        }
        _ => None,
    };
    KEYS.iter().map(|key| (key.path, key.kind.to_string(), default(key), key.meaning)).collect()
}

/// The in-vivo-like recording of a seed, as CSV.
#[pyfunction]
pub(crate) fn record(py: Python<'_>, seed: u64) -> String {
    py.detach(|| trocar_sim::recording::in_vivo_like_csv(seed))
}
