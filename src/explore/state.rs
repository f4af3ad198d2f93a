//! What a page shows: a scenario, and the keys in which it differs.

use std::collections::BTreeMap;

use serde::Deserialize;
use thiserror::Error;

use super::limits::{MAX_KEYS, MAX_NUMBERS, MAX_TICKS};
use trocar_sim::run::RunError;
use trocar_sim::scenario::{
    Key, Kind, Scenario, ScenarioError, Source, Value, find_key, nearest_key, shipped_questions,
};
use trocar_sim::stability::StabilityError;

/// The key in which the two runs of a page differ.
pub(super) const SCHEME: &str = "augmentation.enabled";

/// A scenario by its name in the catalogue, with keys and their values as JSON.
#[derive(Debug, Clone, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct State {
    /// The name.
    pub scenario: String,
    /// What differs from it.
    #[serde(default)]
    pub set: BTreeMap<String, serde_json::Value>,
}

/// Why a page is not shown what it asked for.
#[derive(Debug, Error)]
pub enum StateError {
    /// There is no such scenario.
    #[error("there is no scenario {0:?} on this page")]
    Scenario(String),
    /// There is no such key.
    #[error("there is no key {path:?}{}", .nearest.map(|near| format!("; did you mean {near}?")).unwrap_or_default())]
    Key {
        /// What was asked for.
        path: String,
        /// What may have been meant.
        nearest: Option<&'static str>,
    },
    /// The key is not for pages.
    #[error("{0} cannot be set from the page: {1}")]
    NotForPages(&'static str, &'static str),
    /// The value is none that the key may have.
    #[error("{key} must be {must}")]
    Value {
        /// The key.
        key: &'static str,
        /// What it must be.
        must: String,
    },
    /// Too many keys.
    #[error("{0} keys are changed, at most {MAX_KEYS}")]
    Keys(usize),
    /// Too long a run.
    #[error("{0} ticks, at most {MAX_TICKS} on the page; shorten the run or lengthen the tick")]
    Ticks(u64),
    /// The scenario cannot be run like this.
    #[error(transparent)]
    Refused(#[from] ScenarioError),
    /// The run failed.
    #[error(transparent)]
    Run(#[from] RunError),
    /// There is no map.
    #[error(transparent)]
    Stability(#[from] StabilityError),
    /// The system has no thread left.
    #[error("the insertion cannot be run: {0}")]
    Thread(std::io::Error),
    /// Two axes of a map that are one, or none that a map can have.
    #[error("no map over {0} and {1}: its axes are two parameters, neither of them a part of the other")]
    Axes(String, String),
}

impl State {
    /// The keys with their values, each one that a page may set.
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
        Kind::File | Kind::Text => return Err(StateError::NotForPages(key.path, "pages name no files")),
        _ if key.path == SCHEME => return Err(StateError::NotForPages(key.path, "the page runs both schemes")),
        _ if key.path == "simulation.engine" => {
            return Err(StateError::NotForPages(key.path, "the other engine is a check, for the command line"));
        }
        _ => {}
    }
    let too_long = value.as_array().is_some_and(|list| list.len() > MAX_NUMBERS);
    let toml = toml::Value::try_from(value).ok().filter(|_| !too_long);
    let accepted = toml.and_then(|toml| Value::accept(&key.kind, &toml));
    let value = accepted.ok_or_else(|| StateError::Value { key: key.path, must: key.kind.to_string() })?;
    Ok((key, value))
}

/// A run that is not too long for a page.
pub(super) fn bounded(scenario: Scenario) -> Result<Scenario, StateError> {
    let ticks = scenario.grid.ticks();
    if ticks > MAX_TICKS { Err(StateError::Ticks(ticks)) } else { Ok(scenario) }
}

/// The scenarios of a page: the user's own, if one was named, and those that are shipped.
#[derive(Debug, Clone)]
pub struct Catalogue {
    own: Option<(String, Source)>,
}

impl Catalogue {
    /// The catalogue with a scenario that the user named on the command line, which is shown first.
    #[must_use]
    pub fn new(own: Option<&str>) -> Self {
        let is_shipped = |text: &str| shipped_questions().any(|(name, _)| text == format!("builtin:{name}"));
        Self { own: own.filter(|text| !is_shipped(text)).map(|text| (text.to_owned(), Source::parse(text))) }
    }

    /// Names and questions.
    pub fn entries(&self) -> impl Iterator<Item = (String, String)> {
        let own = self.own.iter().map(|(name, _)| (name.clone(), "named on the command line".to_owned()));
        own.chain(shipped_questions().map(|(name, question)| (format!("builtin:{name}"), question.to_owned())))
    }

    /// Where a scenario of the catalogue comes from: no other file is ever read for a page.
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
        let state = State { scenario: "builtin:augmented.toml".into(), set: [(path.to_owned(), value)].into() };
        state.values().expect_err("refused").to_string()
    }

    #[test]
    fn a_page_names_no_file_and_no_key_that_is_not_one() {
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
    fn a_catalogue_holds_no_file_that_was_not_named() {
        let catalogue = Catalogue::new(Some("mine.toml"));
        assert!(catalogue.source("mine.toml").is_ok() && catalogue.source("builtin:classical.toml").is_ok());
        for name in ["other.toml", "/etc/passwd", "builtin:in_vivo_like.csv", "builtin:../Cargo.toml", ""] {
            assert!(catalogue.source(name).is_err(), "{name}");
        }
        assert!(Catalogue::new(None).source("mine.toml").is_err());
    }
}
