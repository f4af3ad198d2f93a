//! Converts errors to Python exceptions: invalid input becomes a `ValueError`, any other error a `RuntimeError`.

use pyo3::exceptions::{PyOSError, PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::PyType;
use trocar_scenario::ScenarioError;
use trocar_stability::StabilityError;
use trocar_studies::run::RunError;
use trocar_studies::stability_check::CheckError;
use trocar_studies::sweep::SweepError;

/// A `trocar.ScenarioError` with the text, which underlines the line, and its parts as attributes.
pub(crate) fn scenario(py: Python<'_>, error: &ScenarioError) -> PyErr {
    static CLASS: PyOnceLock<Py<PyType>> = PyOnceLock::new();
    let class = match CLASS.import(py, "trocar._errors", "ScenarioError") {
        Ok(class) => class,
        Err(error) => return error,
    };
    let text = in_python(&anstream::adapter::strip_str(&trocar_scenario::underlined(error)).to_string());
    let text = text.replace(&format!("--> {COMMAND_LINE}:"), &format!("--> {CHANGES}:"));
    let (file, line, column) = match &error.place {
        Some(place) => {
            let (line, column) = place.line_and_column();
            let file = if *place.file == *COMMAND_LINE { CHANGES } else { &*place.file };
            (Some(file), Some(line), Some(column))
        }
        None => (None, None, None),
    };
    let (message, remedy) = (in_python(&error.message), error.remedy.as_deref().map(in_python));
    match class.call1((text, message, remedy, file, line, column)) {
        Ok(exception) => PyErr::from_value(exception),
        Err(error) => error,
    }
}

/// A `ValueError` for invalid input.
pub(crate) fn value(error: impl ToString) -> PyErr {
    PyValueError::new_err(in_python(&error.to_string()))
}

/// The name of the settings of the command line in a place, and that of changed keys in Python.
const COMMAND_LINE: &str = "--set";
const CHANGES: &str = "changes";

/// Commands in messages, each with what does the same in Python. The longest ones come first.
const COMMANDS: [(&str, &str); 18] = [
    ("`trocar init --all` writes a scenario with every key", "`trocar.keys()` lists every key"),
    ("`trocar init --all` writes one with every key", "`trocar.keys()` lists every one"),
    ("`trocar sweep --help` lists all of them", "`trocar.metrics()` and `help(trocar.sweep)` list all of them"),
    ("`trocar scenarios` lists the shipped scenarios", "`trocar.shipped()` lists the shipped scenarios"),
    ("`trocar detect FILE --list` shows all", "`trocar.list_signals(FILE)` shows all"),
    ("`trocar detect` with this scenario", "`trocar.run` of this scenario"),
    ("`trocar roc --trials`", "`trocar.roc(trials=True)`"),
    ("`trocar sweep --help`", "`trocar.metrics()`"),
    ("`trocar export fmu`", "`trocar.export`"),
    ("`trocar stability`", "`trocar.stability`"),
    ("`trocar strategies`", "`trocar.strategies`"),
    ("`trocar calibrate`", "`trocar.calibrate`"),
    ("`trocar identify`", "`trocar.identify`"),
    ("`trocar compare`", "`trocar.compare`"),
    ("`trocar detect`", "`trocar.detect`"),
    ("`trocar sweep`", "`trocar.sweep`"),
    ("`trocar roc`", "`trocar.roc`"),
    ("`trocar run`", "`trocar.run`"),
];

/// Replaces the names of options and commands in a message by their Python names: `first_s` for `--first-s`,
/// `force="F:mN"` for `--force F:mN`, `tissue=(50, 600)` for `--tissue 50:600`, `scaling.force=2` for `--set
/// scaling.force=2`, and the functions for the commands in backticks.
#[pyfunction]
pub(crate) fn in_python(message: &str) -> String {
    let mut message = message.to_owned();
    for (command, function) in COMMANDS {
        if message.contains(command) {
            message = message.replace(command, function);
        }
    }
    if let Some((before, path)) = message.split_once("`trocar sweep ")
        && let Some((path, after)) = path.split_once('`')
    {
        message = format!("{before}`trocar.sweep({path:?})`{after}");
    }
    let mut text = String::with_capacity(message.len());
    for (place, quoted_or_not) in message.split('`').enumerate() {
        if place > 0 {
            text.push('`');
        }
        if place % 2 == 1 {
            text.push_str(quoted_or_not);
            continue;
        }
        let mut pieces = quoted_or_not.split("--");
        text.push_str(pieces.next().unwrap_or_default());
        for piece in pieces {
            let end = piece.find(|c: char| !c.is_ascii_lowercase() && c != '-').unwrap_or(piece.len());
            let (name, rest) = piece.split_at(end);
            let is_place = name == "set" && !rest.starts_with(' ');
            if name.is_empty() || is_place || !text.chars().next_back().is_none_or(|c| c == ' ' || c == '(') {
                text.push_str("--");
                text.push_str(piece);
            } else if name == "set" {
                text.push_str(&rest[1..]);
            } else {
                text.push_str(&name.replace('-', "_"));
                text.push_str(&with_value(rest));
            }
        }
    }
    text
}

/// The text after the name of an option, with `="COLUMN:mN"` for ` COLUMN:mN`.
fn with_value(rest: &str) -> String {
    let value = rest.strip_prefix(' ').unwrap_or_default();
    let value = &value[..value.find([' ', ';', ',', ')']).unwrap_or(value.len())];
    let Some((first, second)) = value.split_once(':').filter(|(_, second)| !second.is_empty()) else {
        return rest.to_owned();
    };
    let is_range = first.parse::<f64>().is_ok() && second.parse::<f64>().is_ok();
    let value_in_python = if is_range { format!("({first}, {second})") } else { format!("{value:?}") };
    format!("={value_in_python}{}", &rest[1 + value.len()..])
}

pub(crate) fn run(py: Python<'_>, error: &RunError) -> PyErr {
    match error {
        RunError::Scenario(error) => scenario(py, error),
        other @ RunError::Engine { .. } => PyRuntimeError::new_err(other.to_string()),
    }
}

pub(crate) fn sweep(py: Python<'_>, error: &SweepError) -> PyErr {
    match error {
        SweepError::File(error) => scenario(py, error),
        SweepError::Case { case, values, source } => match &**source {
            RunError::Scenario(error) => {
                let mut error = error.clone();
                error.message = format!("case {case} ({values}): {}", error.message);
                scenario(py, &error)
            }
            other => PyRuntimeError::new_err(other.to_string()),
        },
        SweepError::Changed { .. } | SweepError::Parts { .. } => value(error),
        SweepError::Io { .. } | SweepError::Busy { .. } => PyOSError::new_err(error.to_string()),
    }
}

pub(crate) fn stability(error: &StabilityError) -> PyErr {
    match error {
        StabilityError::Plant(_) | StabilityError::Parameter(_) => value(error),
        _ => PyRuntimeError::new_err(error.to_string()),
    }
}

pub(crate) fn check(py: Python<'_>, error: &CheckError) -> PyErr {
    match error {
        CheckError::Stability(error) => stability(error),
        CheckError::Run(error) => run(py, error),
    }
}

#[cfg(test)]
mod tests {
    use super::in_python;

    #[test]
    fn options_have_their_names_in_python() {
        for (message, expected) in [
            ("--first-s is -1, must be positive", "first_s is -1, must be positive"),
            ("as in --force COLUMN:mN or --force COLUMN:gf; or", r#"as in force="COLUMN:mN" or force="COLUMN:gf"; or"#),
            (
                "no column 'f' (--force or recording.columns.force_n)",
                "no column 'f' (force or recording.columns.force_n)",
            ),
            ("write --set section.key=value, as in --set a.b=2", "write section.key=value, as in a.b=2"),
            ("analyse --tissue 50:600", "analyse tissue=(50, 600)"),
            ("count with `trocar roc`; `trocar sweep --help`", "count with `trocar.roc`; `trocar.metrics()`"),
            ("run it with `trocar sweep my.toml`", "run it with `trocar.sweep(\"my.toml\")`"),
            (" --> --set:1:17", " --> --set:1:17"),
            ("a--b.csv: é -- x", "a--b.csv: é -- x"),
            ("--", "--"),
        ] {
            assert_eq!(in_python(message), expected);
        }
    }
}
