//! Designs: the settings that are best for a group of patients.

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use pyo3::exceptions::PyOSError;
use pyo3::prelude::*;
use trocar_document::{Study as _, to_json};
use trocar_report::{OutputError, write_file};
use trocar_scenario::Source;
use trocar_studies::design::{Design, DesignError, Follower, Problem, Stage, State};
use trocar_studies::run::seeds_without_effect;

use crate::interrupt::interruptible_with_progress;
use crate::{convert, document, error};

/// The stage of a design, with the number of its units that are done, and of all.
type Progress = Arc<Mutex<(&'static str, u64, u64)>>;

/// The content of `design.json`, the document, and the scenario files with their names.
type Designed<'py> = (Bound<'py, PyAny>, Bound<'py, PyAny>, Vec<(String, String)>);

/// Counts the units of the present stage, and keeps the state of the search in a file.
struct Counted {
    progress: Progress,
    file: Option<PathBuf>,
}

impl Follower for Counted {
    type Error = OutputError;

    fn at(&self, stage: Stage, done: u64, all: u64) {
        let units = match stage {
            Stage::Generation(_) => "runs of the search",
            Stage::Certificates => "certificates",
            Stage::OtherPatients => "runs on other patients",
        };
        *self.progress.lock().unwrap_or_else(PoisonError::into_inner) = (units, done, all);
    }

    fn advance(&self, units: u64) {
        self.progress.lock().unwrap_or_else(PoisonError::into_inner).1 += units;
    }

    fn keep(&self, state: &State) -> Result<(), OutputError> {
        self.file.as_deref().map_or(Ok(()), |file| write_file(file, state.to_json().as_bytes()))
    }
}

/// Designs. `source` is the path or the text of a design file. Calls `tell` with what is counted, the number of done units, and of all.
#[pyfunction]
pub(crate) fn design<'py>(
    py: Python<'py>,
    source: &str,
    is_text: bool,
    settings: Vec<String>,
    search: Option<PathBuf>,
    threads: usize,
    tell: Option<Py<PyAny>>,
) -> PyResult<Designed<'py>> {
    let source = match is_text {
        true => Source::Text { name: "design".into(), text: Arc::from(source) },
        false => Source::parse(source),
    };
    let problem = Problem::load(&source, &settings).map_err(|error| error::scenario(py, &error))?;
    let mut state = stored(search.as_deref(), &problem)?;
    let example = problem.example().map_err(|error| error::scenario(py, &error))?;
    let warnings = match example.has_random_numbers() {
        true => vec![],
        false => seeds_without_effect(&[example], problem.validation.seeds.max(problem.training.seeds)),
    };
    let progress: Progress = Arc::default();
    let follower = Counted { progress: progress.clone(), file: search };
    let tell = |py: Python<'_>| {
        let counted = *progress.lock().unwrap_or_else(PoisonError::into_inner);
        tell.as_ref().filter(|_| !counted.0.is_empty()).map_or(Ok(()), |tell| tell.call1(py, counted).map(drop))
    };
    let designed = interruptible_with_progress(py, threads, tell, move |stop| {
        let design = Design::of(&problem, &mut state, stop, &follower)?;
        let study = design.study(&problem, &state);
        let mut document = study.document();
        document.warnings.splice(0..0, warnings);
        let scenarios = document.files.iter().map(|file| (file.name.to_string(), file.text.clone())).collect();
        Ok((to_json(&document.json), document::contents(&document, false), scenarios))
    })?;
    let (json, contents, scenarios) = designed.map_err(|error| match error {
        DesignError::Run(error) => error::run(py, &error),
        DesignError::Keep(error) => PyOSError::new_err(error.to_string()),
        DesignError::Stopped(_) => error::value("the design was stopped"),
    })?;
    Ok((convert::parsed(py, &json)?, convert::python(py, &contents)?, scenarios))
}

/// The state in a file, or that before the first generation.
fn stored(file: Option<&Path>, problem: &Problem) -> PyResult<State> {
    let Some(file) = file else { return Ok(State::new(problem)) };
    match std::fs::read_to_string(file) {
        Ok(text) => State::stored(&text, problem).ok_or_else(|| {
            error::value(format!(
                "{} does not hold the search of this design: name another file, or remove this one",
                file.display()
            ))
        }),
        Err(reason) if reason.kind() == std::io::ErrorKind::NotFound => Ok(State::new(problem)),
        Err(reason) => Err(PyOSError::new_err(format!("{}: {reason}", file.display()))),
    }
}
