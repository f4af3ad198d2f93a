//! Operating characteristics of detectors, and the synthetic recordings for their evaluation.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use trocar_core::detector::{Detector, DistanceKind};
use trocar_metrics::RUPTURE_WINDOW_S;
use trocar_recording::InVivoLikeVariant;
use trocar_scenario::{DetectionSpec, Source, Values};
use trocar_studies::roc::trials::Trial;
use trocar_studies::roc::{RocError, Signal, Study, UserDefinedPoints};
use trocar_studies::run::RunError;

use crate::arrays::put;
use crate::detect::Samples;
use crate::interrupt::interruptible_with_progress;
use crate::recording::Recording;
use crate::scenario::Scenario;
use crate::user_defined::{CompiledPart, Failure, detector};
use crate::{convert, document, error};

const SHIPPED: &str = "paper/classical";

type Judged<'py> = (Bound<'py, PyAny>, Bound<'py, PyAny>);

/// A user-defined detector: its name, its threshold (if any) and the part.
type UserDefinedDetector<'py> = (String, Option<f64>, Bound<'py, PyAny>);

/// Evaluates built-in detectors, by name, and user-defined ones on a recording, the closed loop of a scenario,
/// synthetic recordings, or by default the shipped insertion.
///
/// Returns the content of `roc.json` and the document. Calls `tell` with the numbers of completed and of all cases:
/// each user-defined detector is a case, and all built-in ones together are another.
#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "the Python wrapper passes them by name")]
pub(crate) fn roc<'py>(
    py: Python<'py>,
    name: &str,
    scenario: Option<&Scenario>,
    recording: Option<&Recording>,
    is_trials: bool,
    settings: Vec<String>,
    kinds: Vec<String>,
    user_defined: Vec<UserDefinedDetector<'py>>,
    noise_std_n: Vec<f64>,
    seeds: u64,
    thresholds: usize,
    within_s: f64,
    threads: usize,
    tell: Option<Py<PyAny>>,
) -> PyResult<Judged<'py>> {
    let kinds = kinds.iter().map(|word| kind(word)).collect::<PyResult<Vec<_>>>()?;
    noise_std_n.iter().try_for_each(|std_n| within("noise_std_n", *std_n, Study::NOISE_STDS_N))?;
    within("within_s", within_s, (0.0, RUPTURE_WINDOW_S))?;
    within("seeds", seeds as f64, (1.0, 1e6))?;
    within("thresholds", thresholds as f64, (2.0, 1000.0))?;
    let refuse = |error: RocError| of_study(py, &error);
    let refuse_scenario = |error| error::scenario(py, &error);
    let signal = match (scenario, recording) {
        (Some(scenario), _) => Signal::closed_loop(scenario.scenario.clone(), &kinds).map_err(refuse)?,
        (None, Some(recording)) => {
            let values = Values::from_settings(name, &settings).map_err(refuse_scenario)?;
            let (spec, _) = Samples::kept(recording).spec(values).map_err(|refusal| refusal.raise(py))?;
            Signal::recorded(name.to_owned(), &spec, &kinds).map_err(refuse)?
        }
        (None, None) => {
            let mut values = Values::load(&Source::parse(SHIPPED), &settings).map_err(refuse_scenario)?;
            let spec = DetectionSpec::resolve(&mut values).map_err(refuse_scenario)?;
            if is_trials {
                Signal::trials(&spec, &kinds)
            } else {
                Signal::recorded(name.to_owned(), &spec, &kinds).map_err(refuse)?
            }
        }
    };
    let study = Study { signals: vec![signal], noise_std_n, seeds, thresholds, within_s };
    // A case evaluates one user-defined detector, or all built-in ones together.
    let all = study.noise_std_n.len() as u64 * seeds * (user_defined.len() as u64 + u64::from(!kinds.is_empty()));
    let done = Arc::new(AtomicU64::new(0));
    let counted = done.clone();
    let tell = |py: Python<'_>| {
        let done = done.load(Ordering::Relaxed);
        tell.as_ref().map_or(Ok(()), |tell| tell.call1(py, (done, all)).map(drop))
    };
    let (names, parts): (Vec<_>, Vec<_>) =
        user_defined.into_iter().map(|(name, threshold, part)| ((name, threshold.unwrap_or(f64::NAN)), part)).unzip();
    let compiled = parts.iter().map(CompiledPart::detector).collect::<PyResult<Option<Vec<_>>>>()?;
    let points = match compiled {
        Some(compiled) if !parts.is_empty() => {
            let (study, counted) = (study.clone(), counted.clone());
            let points = interruptible_with_progress(py, threads, tell, move |_| {
                study.run_user_defined_side_by_side(compiled.len(), |index, input, _, alarms| {
                    let failure = Failure::default();
                    let mut detector = compiled[index].begin(&failure);
                    alarms.extend((0..input.len()).filter(|sample| detector.update(&input[*sample]).alarm));
                    counted.fetch_add(1, Ordering::Relaxed);
                    failure.take().map_or(Ok(()), Err).map_err(UserDefinedError::Python)
                })
            })?;
            points.map_err(|error| error.raise(py))?
        }
        Some(_) | None => user_defined_points(py, &study, &parts, || {
            done.fetch_add(1, Ordering::Relaxed);
            tell(py)
        })?,
    };
    // Without built-in detectors, run no case a second time.
    let study = Study { seeds: if kinds.is_empty() { 0 } else { seeds }, ..study };
    let judged = interruptible_with_progress(py, threads, tell, move |stop| {
        let count = || {
            counted.fetch_add(1, Ordering::Relaxed);
        };
        study.run(stop, &count)
    })?;
    tell(py)?;
    let mut judged = judged.map_err(refuse)?;
    let evaluated: Vec<_> =
        names.into_iter().zip(points).map(|((name, threshold), points)| (name, threshold, points)).collect();
    judged.add_user_defined(&evaluated);
    let document = judged.document(seeds);
    Ok((convert::python(py, &document.json)?, document::dictionary(py, &document, false)?))
}

/// Evaluates user-defined detectors. Calls `count` after each case of each detector.
fn user_defined_points<'py>(
    py: Python<'py>,
    study: &Study,
    parts: &[Bound<'py, PyAny>],
    count: impl Fn() -> PyResult<()>,
) -> PyResult<Vec<UserDefinedPoints>> {
    if parts.is_empty() {
        return Ok(vec![]);
    }
    let failure = Failure::default();
    let judged = study.run_user_defined(parts.len(), |index, input, _, alarms| {
        py.check_signals().map_err(UserDefinedError::Python)?;
        // Each case begins with a reset.
        let mut detector = detector(&parts[index], &failure).map_err(UserDefinedError::Python)?;
        alarms.extend((0..input.len()).filter(|sample| detector.update(&input[*sample]).alarm));
        failure.take().map_or_else(&count, Err).map_err(UserDefinedError::Python)
    });
    judged.map_err(|error| error.raise(py))
}

enum UserDefinedError {
    Python(PyErr),
    Study(RocError),
}

impl UserDefinedError {
    fn raise(self, py: Python<'_>) -> PyErr {
        match self {
            Self::Python(error) => error,
            Self::Study(error) => of_study(py, &error),
        }
    }
}

impl From<RocError> for UserDefinedError {
    fn from(error: RocError) -> Self {
        Self::Study(error)
    }
}

fn of_study(py: Python<'_>, error: &RocError) -> PyErr {
    match error {
        RocError::Scenario(error) | RocError::Run(RunError::Scenario(error)) => error::scenario(py, error),
        other => error::value(other),
    }
}

fn kind(word: &str) -> PyResult<DistanceKind> {
    DistanceKind::ALL.into_iter().find(|kind| kind.word() == word).ok_or_else(|| {
        error::value(format!("there is no detector {word}; the built-in ones are {}", DistanceKind::WORDS.join(", ")))
    })
}

fn within(name: &str, value: f64, (low, high): (f64, f64)) -> PyResult<()> {
    // False for NaN.
    if (low..=high).contains(&value) {
        return Ok(());
    }
    Err(error::value(format!("{name} is {value}, must be from {low} to {high}")))
}

#[pyfunction]
pub(crate) fn detectors() -> Vec<&'static str> {
    DistanceKind::WORDS.to_vec()
}

/// The in-vivo-like recording of a seed, with user-defined ruptures, as CSV.
#[pyfunction]
pub(crate) fn record(
    py: Python<'_>,
    seed: u64,
    drop_n: Option<f64>,
    fall_s: Option<f64>,
    depth_m: Option<f64>,
) -> PyResult<String> {
    let limited = [
        ("drop_n", drop_n, InVivoLikeVariant::DROPS_N),
        ("sharpness_s", fall_s, InVivoLikeVariant::FALLS_S),
        ("depth_m", depth_m, InVivoLikeVariant::DEPTHS_M),
    ];
    for (name, value, limits) in limited {
        value.map_or(Ok(()), |value| within(name, value, limits))?;
    }
    let variant = InVivoLikeVariant { drop_n, fall_s, depth_m };
    Ok(py.detach(|| trocar_recording::in_vivo_like_variant_csv(seed, &variant)))
}

/// A synthetic recording by its number, from 1: its columns and its properties.
#[pyfunction]
pub(crate) fn trial(py: Python<'_>, number: u64) -> PyResult<(Bound<'_, PyDict>, Bound<'_, PyDict>)> {
    let trial = py.detach(|| Trial::new(Trial::BEFORE_FIRST.wrapping_add(number)));
    let (columns, about) = (PyDict::new(py), PyDict::new(py));
    let count = trial.position_m.len();
    put(&columns, "time_s", (0..count).map(|sample| sample as f64 * trial.tick_s).collect())?;
    about.set_item("is_above_noise", trial.falls.iter().map(|fall| trial.is_above_noise(fall)).collect::<Vec<_>>())?;
    about.set_item("ruptures_s", PyArray1::from_iter(py, trial.falls.iter().map(|fall| fall.start_s)))?;
    about.set_item("durations_s", PyArray1::from_iter(py, trial.falls.iter().map(|fall| fall.duration_s)))?;
    about.set_item("drops_n", PyArray1::from_iter(py, trial.falls.iter().map(|fall| fall.drop_n)))?;
    about.set_item("contact_m", trial.contact_m)?;
    about.set_item("contact", word(trial.knowledge))?;
    about.set_item("noise_std_n", trial.noise_std_n)?;
    about.set_item("noise", word(trial.noise))?;
    about.set_item("hand", word(trial.hand))?;
    about.set_item("matter", word(trial.matter))?;
    put(&columns, "position_m", trial.position_m)?;
    put(&columns, "force_n", trial.force_n)?;
    Ok((columns, about))
}

fn word(variant: impl std::fmt::Debug) -> String {
    let mut word = String::new();
    for letter in format!("{variant:?}").chars() {
        if letter.is_uppercase() && !word.is_empty() {
            word.push(' ');
        }
        word.extend(letter.to_lowercase());
    }
    word
}
