//! The state of a page: a scenario and the changed keys.

use std::collections::BTreeMap;

use serde::Deserialize;
use thiserror::Error;

use super::limits::{MAX_KEYS, MAX_NUMBERS, MAX_TICKS};
use trocar_sim::run::RunError;
use trocar_sim::scenario::{
    Key, Kind, Scenario, ScenarioError, Source, Value, find_key, nearest_key, shipped_questions,
};
use trocar_sim::stability::StabilityError;

/// The key that differs between the two runs of a page.
pub(super) const SCHEME: &str = "augmentation.enabled";

/// A scenario by its name in the catalogue, with keys and their values as JSON.
#[derive(Debug, Clone, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct State {
    /// Name of the scenario.
    pub scenario: String,
    /// The changed keys and their values.
    #[serde(default)]
    pub set: BTreeMap<String, serde_json::Value>,
}

/// The refusal of a request.
#[derive(Debug, Error)]
pub enum StateError {
    /// The scenario does not exist.
    #[error("this page has no scenario {0:?}")]
    Scenario(String),
    /// The key does not exist.
    #[error("there is no key {path:?}{}", .nearest.map(|near| format!("; did you mean {near}?")).unwrap_or_default())]
    Key {
        /// The requested key.
        path: String,
        /// The most similar key.
        nearest: Option<&'static str>,
    },
    /// The key cannot be set from a page.
    #[error("{0} cannot be set from the page: {1}")]
    NotForPages(&'static str, &'static str),
    /// The value is invalid.
    #[error("{key} must be {must}")]
    Value {
        /// The key.
        key: &'static str,
        /// The required value.
        must: String,
    },
    /// Too many keys.
    #[error("{0} keys are changed; the maximum is {MAX_KEYS}")]
    Keys(usize),
    /// The run is too long.
    #[error("the run has {0} ticks; the maximum on this page is {MAX_TICKS}; shorten the run or lengthen the tick")]
    Ticks(u64),
    /// The scenario is invalid.
    #[error(transparent)]
    Refused(#[from] ScenarioError),
    /// The run failed.
    #[error(transparent)]
    Run(#[from] RunError),
    /// The stability analysis failed.
    #[error(transparent)]
    Stability(#[from] StabilityError),
    /// No thread is available.
    #[error("cannot start the insertion: {0}")]
    Thread(std::io::Error),
    /// The axes of a map are invalid.
    #[error("no map over {0} and {1}: the axes must be two independent parameters")]
    Axes(String, String),
}

impl State {
    /// Returns the changed keys and their checked values.
    ///
    /// # Errors
    /// [`StateError`].
    pub fn values(&self) -> Result<Vec<(&'static Key, Value)>, StateError> {
        if self.set.len() > MAX_KEYS {
            return Err(StateError::Keys(self.set.len()));
        }
        self.set.iter().map(|(path, value)| accept(path, value)).collect()
    }
}

fn accept(path: &str, value: &serde_json::Value) -> Result<(&'static Key, Value), StateError> {
    let Some(key) = find_key(path) else {
        return Err(StateError::Key { path: path.chars().take(80).collect(), nearest: nearest_key(path) });
    };
    match key.kind {
        Kind::File | Kind::Text => return Err(StateError::NotForPages(key.path, "a page cannot name files")),
        _ if key.path == SCHEME => return Err(StateError::NotForPages(key.path, "the page always runs both schemes")),
        _ if key.path == "simulation.engine" => {
            return Err(StateError::NotForPages(key.path, "use the command line for the reference engine"));
        }
        _ => {}
    }
    let too_long = value.as_array().is_some_and(|list| list.len() > MAX_NUMBERS);
    let toml = toml::Value::try_from(value).ok().filter(|_| !too_long);
    let accepted = toml.and_then(|toml| Value::accept(&key.kind, &toml));
    let value = accepted.ok_or_else(|| StateError::Value { key: key.path, must: key.kind.to_string() })?;
    Ok((key, value))
}

/// Returns the scenario, or an error if its run is too long for a page.
pub(super) fn bounded(scenario: Scenario) -> Result<Scenario, StateError> {
    let ticks = scenario.grid.ticks();
    if ticks > MAX_TICKS { Err(StateError::Ticks(ticks)) } else { Ok(scenario) }
}

/// The scenarios of a page: the user's scenario, if any, and the shipped scenarios.
#[derive(Debug, Clone)]
pub struct Catalogue {
    own: Option<(String, Source)>,
}

impl Catalogue {
    /// Returns the catalogue with the scenario of the command line, if any, as the first.
    #[must_use]
    pub fn new(own: Option<&str>) -> Self {
        let own = own.map(Source::parse).filter(|source| !matches!(source, Source::Builtin(_)));
        Self { own: own.map(|source| (source.display(), source)) }
    }

    /// Returns names and questions.
    pub fn entries(&self) -> impl Iterator<Item = (String, String)> {
        let own = self.own.iter().map(|(name, _)| (name.clone(), "from the command line".to_owned()));
        own.chain(shipped_questions().map(|(name, question)| (format!("builtin:{name}"), question.to_owned())))
    }

    /// Returns the source of a scenario in the catalogue. A page cannot read any other file.
    ///
    /// # Errors
    /// [`StateError::Scenario`].
    pub fn source(&self, name: &str) -> Result<Source, StateError> {
        let own = self.own.iter().find(|(own, _)| own == name).map(|(_, source)| source.clone());
        let shipped = || {
            let bare = name.strip_prefix("builtin:")?;
            shipped_questions().any(|(known, _)| known == bare).then(|| Source::Builtin(bare.to_owned()))
        };
        own.or_else(shipped).ok_or_else(|| StateError::Scenario(name.chars().take(80).collect()))
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
    fn a_catalogue_has_only_given_files() {
        let catalogue = Catalogue::new(Some("mine.toml"));
        assert!(catalogue.source("mine.toml").is_ok() && catalogue.source("builtin:paper/classical.toml").is_ok());
        for name in ["other.toml", "/etc/passwd", "builtin:in_vivo_like.csv", "builtin:../Cargo.toml", ""] {
            assert!(catalogue.source(name).is_err(), "{name}");
        }
        assert!(Catalogue::new(None).source("mine.toml").is_err());
    }
}
