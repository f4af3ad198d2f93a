use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::limits::{MAX_KEYS, MAX_NUMBERS, MAX_TICKS};
use trocar_figures::FigureError;
use trocar_report::PictureError;
use trocar_scenario::{KeyAt, Kind, Scenario, ScenarioError, Source, Value, find_key, nearest_key, shipped_questions};
use trocar_studies::run::RunError;
use trocar_studies::stability_check::CheckError;

/// Differs between the two runs of a page.
pub(super) const SCHEME: &str = "augmentation.enabled";

/// With changed keys and their values as JSON.
#[derive(Debug, Clone, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct State {
    pub scenario: String,
    #[serde(default)]
    pub set: BTreeMap<String, serde_json::Value>,
}

#[derive(Debug, Error)]
pub enum StateError {
    #[error("this page has no scenario {0:?}")]
    Scenario(String),
    #[error("there is no key {path:?}{}", .nearest.map(|near| format!("; did you mean {near}?")).unwrap_or_default())]
    Key { path: String, nearest: Option<&'static str> },
    #[error("{0} cannot be set from the page: {1}")]
    NotForPages(String, &'static str),
    #[error("{key} must be {must}")]
    Value { key: String, must: String },
    #[error("{}", .0.iter().map(ToString::to_string).collect::<Vec<_>>().join("; "))]
    Several(Vec<StateError>),
    #[error("{0} keys are changed; the maximum is {MAX_KEYS}")]
    Keys(usize),
    #[error("the run has {0} ticks; the maximum on this page is {MAX_TICKS}; shorten the run or lengthen the tick")]
    Ticks(u64),
    #[error(transparent)]
    Refused(#[from] ScenarioError),
    #[error(transparent)]
    Run(#[from] RunError),
    #[error(transparent)]
    Stability(#[from] CheckError),
    #[error(transparent)]
    Figure(#[from] FigureError),
    #[error(transparent)]
    Picture(#[from] PictureError),
    #[error("the width {0}")]
    Width(String),
    #[error("cannot write the answer: {0}")]
    Message(serde_json::Error),
    #[error("there is no map over {0} and {1}; choose two independent parameters")]
    Axes(String, String),
}

impl State {
    /// The changed keys with their validated values.
    pub fn values(&self) -> Result<Vec<(KeyAt, Value)>, StateError> {
        if self.set.len() > MAX_KEYS {
            return Err(StateError::Keys(self.set.len()));
        }
        let (mut values, mut errors) = (vec![], vec![]);
        for (path, value) in &self.set {
            match accept(path, value) {
                Ok(value) => values.push(value),
                Err(error) => errors.push(error),
            }
        }
        match errors.len() {
            0 => Ok(values),
            1 => Err(errors.remove(0)),
            _ => Err(StateError::Several(errors)),
        }
    }
}

impl StateError {
    pub(super) fn reasons(&self) -> Vec<String> {
        let one = |error: &ScenarioError| {
            let remedy = error.remedy.as_ref().map_or(String::new(), |remedy| format!("; {remedy}"));
            format!("{}{remedy}", error.message)
        };
        match self {
            Self::Several(errors) => errors.iter().flat_map(Self::reasons).collect(),
            Self::Refused(error) => std::iter::once(error).chain(&error.others).map(one).collect(),
            _ => vec![self.to_string()],
        }
    }
}

fn accept(path: &str, value: &serde_json::Value) -> Result<(KeyAt, Value), StateError> {
    let Some(key) = find_key(path) else {
        return Err(StateError::Key { path: path.chars().take(80).collect(), nearest: nearest_key(path) });
    };
    match key.kind {
        Kind::File | Kind::Text => {
            return Err(StateError::NotForPages(key.path.into_owned(), "a page cannot name files"));
        }
        _ if key.path == SCHEME => {
            return Err(StateError::NotForPages(key.path.into_owned(), "the page always runs both schemes"));
        }
        _ if key.path == "simulation.engine" => {
            return Err(StateError::NotForPages(
                key.path.into_owned(),
                "use the command line for the reference engine",
            ));
        }
        _ => {}
    }
    let too_long = value.as_array().is_some_and(|list| list.len() > MAX_NUMBERS);
    let toml = toml::Value::try_from(value).ok().filter(|_| !too_long);
    let accepted = toml.and_then(|toml| Value::accept(&key.kind, &toml));
    let value = accepted.ok_or_else(|| StateError::Value { key: key.path.to_string(), must: key.kind.to_string() })?;
    Ok((key, value))
}

pub(super) fn bounded(scenario: Scenario) -> Result<Scenario, StateError> {
    let ticks = scenario.grid.ticks();
    if ticks > MAX_TICKS { Err(StateError::Ticks(ticks)) } else { Ok(scenario) }
}

/// A scenario in the menu of a page.
#[derive(Debug, Clone, Serialize)]
pub struct Entry {
    pub name: String,
    /// The beginning of the question.
    pub title: String,
    pub question: String,
    /// The question of the scenario's group.
    pub group: &'static str,
}

/// The shipped folders, each with its question.
const GROUPS: [(&str, &str); 8] = [
    ("paper", "Does augmentation hold the needle? The paper's recordings"),
    ("layers", "What happens in layers of tissue?"),
    ("tearing", "What happens in tissue that tears?"),
    ("hand", "What does the hand of the operator change?"),
    ("strategies", "How to continue after the freeze?"),
    ("sensing", "What if sensors or settings are not ideal?"),
    ("link", "What does the link change?"),
    ("passivity", "Is a delayed link stable, and at what cost?"),
];

fn group(name: &str) -> &'static str {
    let folder = name.split('/').next().unwrap_or_default();
    GROUPS.iter().find(|(known, _)| *known == folder).map_or("Other scenarios", |(_, question)| question)
}

/// The user's scenario, if any, and the shipped scenarios.
#[derive(Debug, Clone)]
pub struct Catalogue {
    given: Option<(String, Source)>,
}

impl Catalogue {
    /// The scenario of the command line, if any, is the first.
    pub fn new(given: Option<&str>) -> Self {
        let source = given.map(Source::parse).filter(|source| !matches!(source, Source::Builtin(_)));
        Self { given: source.map(|source| (source.display(), source)) }
    }

    /// The user's scenario first.
    pub fn entries(&self) -> impl Iterator<Item = Entry> {
        let given = self.given.iter().map(|(name, _)| Entry {
            name: name.clone(),
            title: name.clone(),
            question: "From the command line.".to_owned(),
            group: "Your scenario",
        });
        given.chain(shipped_questions().map(|(name, question)| Entry {
            name: format!("builtin:{name}"),
            title: question.split([':', '?']).next().unwrap_or(question).to_owned(),
            question: question.to_owned(),
            group: group(name),
        }))
    }

    /// A page cannot read any other file.
    pub fn source(&self, name: &str) -> Result<Source, StateError> {
        let given = self.given.iter().find(|(given, _)| given == name).map(|(_, source)| source.clone());
        let shipped = || {
            let bare = name.strip_prefix("builtin:")?;
            shipped_questions().any(|(known, _)| known == bare).then(|| Source::Builtin(bare.to_owned()))
        };
        given.or_else(shipped).ok_or_else(|| StateError::Scenario(name.chars().take(80).collect()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refused(path: &str, value: serde_json::Value) -> String {
        let state = State { scenario: "builtin:paper/augmented.toml".into(), set: [(path.to_owned(), value)].into() };
        state.values().expect_err("refused").to_string()
    }

    #[test]
    fn a_page_cannot_name_files_or_unknown_keys() {
        for key in ["recording.file", "channel.delays_file", "name"] {
            assert!(refused(key, "/etc/passwd".into()).contains("cannot be set"), "{key}");
        }
        assert!(refused("[recording]\nfile", "/etc/passwd".into()).contains("no key"));
        assert!(refused("scaling.forc", 1.into()).contains("did you mean scaling.force?"));
        assert!(refused("scaling.force", "fast".into()).contains("must be a number"));
        assert!(refused("scaling.force", serde_json::Value::Null).contains("must be a number"));
        assert!(refused("augmentation.enabled", false.into()).contains("both schemes"));
    }

    #[test]
    fn a_catalogue_contains_only_the_given_files() {
        let catalogue = Catalogue::new(Some("mine.toml"));
        assert!(catalogue.source("mine.toml").is_ok() && catalogue.source("builtin:paper/classical.toml").is_ok());
        for name in ["other.toml", "/etc/passwd", "builtin:in_vivo_like.csv", "builtin:../Cargo.toml", ""] {
            assert!(catalogue.source(name).is_err(), "{name}");
        }
        assert!(Catalogue::new(None).source("mine.toml").is_err());
    }
}
