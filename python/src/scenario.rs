//! Scenarios.

use std::path::PathBuf;
use std::sync::Arc;

use pyo3::prelude::*;
use serde_json::Value as Json;
use trocar_scenario::{FileContents, KEYS, KeptFiles, ScenarioError, Source, shipped_questions};

use crate::recording::Recording;
use crate::{convert, error};

#[pyclass(frozen, module = "trocar._core")]
pub(crate) struct Scenario {
    pub(crate) scenario: trocar_scenario::Scenario,
    /// The source, which keeps the content of the files that were read.
    pub(crate) source: Source,
    /// The settings of each call; the first ones are those of loading the scenario.
    pub(crate) settings: Vec<Vec<String>>,
    /// The recordings in memory that the settings name, held so that their names stay valid.
    pub(crate) recordings: Vec<Recording>,
}

impl Scenario {
    /// Loads a scenario. One that was changed is given its former self as `other`.
    fn of(
        py: Python<'_>,
        other: Option<&Self>,
        source: Source,
        settings: Vec<Vec<String>>,
        recordings: Vec<Recording>,
    ) -> PyResult<Self> {
        let lists: Vec<&[String]> = settings.iter().map(Vec::as_slice).collect();
        let other = other.map(|other| &other.scenario);
        let load = || trocar_scenario::Scenario::load_sharing(other, &source, &lists);
        let scenario = py.detach(load).map_err(|error| error::scenario(py, &named(error, &source)))?;
        Ok(Self { scenario, source, settings, recordings })
    }
}

/// The content of files: each path with its canonical form; the bytes of a path; the recording of a path, with the
/// way in which it was read.
type Files = (Vec<(PathBuf, PathBuf)>, Vec<(PathBuf, Vec<u8>)>, Vec<(PathBuf, String, Recording)>);

type Origin = (Option<PathBuf>, String, Option<String>, Vec<Vec<String>>, Vec<Recording>, Files);

/// The same as [`Files`], with Python's recordings.
type GivenFiles<'py> =
    (Vec<(PathBuf, PathBuf)>, Vec<(PathBuf, Vec<u8>)>, Vec<(PathBuf, String, PyRef<'py, Recording>)>);

fn files_of((canonical, bytes, recordings): GivenFiles<'_>) -> KeptFiles {
    KeptFiles::of(FileContents {
        canonical: canonical.into_iter().collect(),
        bytes: bytes.into_iter().map(|(path, bytes)| (path, bytes.into())).collect(),
        recordings: recordings.into_iter().map(|(path, how, recording)| ((path, how), recording.shared())).collect(),
    })
}

fn cloned(recordings: &[PyRef<'_, Recording>]) -> Vec<Recording> {
    recordings.iter().map(|recording| Recording::clone(recording)).collect()
}

pub(crate) fn named(mut error: ScenarioError, source: &Source) -> ScenarioError {
    let file = source.display();
    if error.place.is_none() && !error.message.contains(&file) {
        error.message = format!("{file}: {}", error.message);
    }
    error
}

pub(crate) fn text_source(name: &str, text: &str) -> Source {
    Source::Text { name: name.into(), text: Arc::from(text) }
}

#[pymethods]
impl Scenario {
    #[staticmethod]
    fn load(
        py: Python<'_>,
        path: &str,
        settings: Vec<Vec<String>>,
        recordings: Vec<PyRef<'_, Recording>>,
    ) -> PyResult<Self> {
        Self::of(py, None, Source::parse(path).keeping(KeptFiles::default()), settings, cloned(&recordings))
    }

    /// Restores a scenario from its [`Scenario::origin`].
    #[staticmethod]
    fn restored(
        py: Python<'_>,
        path: Option<PathBuf>,
        name: &str,
        text: Option<&str>,
        settings: Vec<Vec<String>>,
        recordings: Vec<PyRef<'_, Recording>>,
        files: GivenFiles<'_>,
    ) -> PyResult<Self> {
        let source = match path {
            Some(path) => path
                .to_str()
                .filter(|path| path.starts_with("builtin:"))
                .map_or_else(|| Source::Disk(path.clone()), Source::parse),
            None => text_source(name, text.unwrap_or_default()),
        };
        Self::of(py, None, source.keeping(files_of(files)), settings, cloned(&recordings))
    }

    #[staticmethod]
    fn from_text(
        py: Python<'_>,
        name: &str,
        text: &str,
        settings: Vec<Vec<String>>,
        recordings: Vec<PyRef<'_, Recording>>,
    ) -> PyResult<Self> {
        Self::of(py, None, text_source(name, text).keeping(KeptFiles::default()), settings, cloned(&recordings))
    }

    /// The scenario with additional settings, which override earlier ones and may change their kinds. It
    /// reads no file a second time.
    fn replace(&self, py: Python<'_>, settings: Vec<String>, recordings: Vec<PyRef<'_, Recording>>) -> PyResult<Self> {
        let settings = self.settings.iter().cloned().chain([settings]).collect();
        let recordings = self.recordings.iter().cloned().chain(cloned(&recordings)).collect();
        Self::of(py, Some(self), self.source.clone(), settings, recordings)
    }

    /// The source: the path or `None`, the name, the text or `None`, the settings of each call, the recordings in
    /// memory, and the content of the read files.
    fn origin(&self) -> Origin {
        let content = self.source.kept().map(KeptFiles::content).unwrap_or_default();
        let files = (
            content.canonical.into_iter().collect(),
            content.bytes.into_iter().map(|(path, bytes)| (path, bytes.to_vec())).collect(),
            content
                .recordings
                .into_iter()
                .map(|((path, how), recording)| (path, how, Recording::of(recording)))
                .collect(),
        );
        let (path, text) = match self.source.plain() {
            Source::Text { text, .. } => (None, Some(text.to_string())),
            Source::Disk(path) => (Some(path.clone()), None),
            source => (Some(source.display().into()), None),
        };
        let name = if text.is_some() { self.source.display() } else { self.source.stem() };
        (path, name, text, self.settings.clone(), self.recordings.clone(), files)
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

#[pyfunction]
pub(crate) fn shipped() -> Vec<(String, &'static str)> {
    shipped_questions().map(|(name, question)| (format!("builtin:{name}"), question)).collect()
}

/// Returns every key of a scenario: path, type, default as TOML or `None`, meaning.
#[pyfunction]
pub(crate) fn keys() -> Vec<(&'static str, String, Option<String>, &'static str)> {
    let default = |key: &trocar_scenario::Key| match key.fallback {
        trocar_scenario::Fallback::Value(value) => Some(trocar_scenario::Value::from(value).to_toml().to_string()),
        _ => None,
    };
    KEYS.iter().map(|key| (key.path, key.kind.to_string(), default(key), key.meaning)).collect()
}
