//! Values in sweep files and design files, with their error messages.

use trocar_scenario::{Entry, Place, ScenarioError, harmless_name};

pub(crate) fn must(entry: &Entry, what: &str) -> ScenarioError {
    ScenarioError::new(format!("{} is {}, must be {what}", entry.path, entry.written))
        .at(Some(entry.value_place.clone()))
}

pub(crate) fn whole(entry: &Entry, min: u64, max: u64) -> Result<u64, ScenarioError> {
    let value = entry.value.as_integer().and_then(|value| u64::try_from(value).ok());
    value
        .filter(|value| (min..=max).contains(value))
        .ok_or_else(|| must(entry, &format!("a whole number from {min} to {max}")))
}

pub(crate) fn flag(entry: &Entry) -> Result<bool, ScenarioError> {
    entry.value.as_bool().ok_or_else(|| must(entry, "true or false"))
}

pub(crate) fn name(entry: &Entry) -> Result<String, ScenarioError> {
    let is_harmless = |name: &&str| harmless_name(name) == **name;
    let name = entry.value.as_str().filter(is_harmless);
    name.map(str::to_owned).ok_or_else(|| must(entry, "a string of letters, digits, '-' and '_', which names a folder"))
}

pub(crate) fn line(entry: &Entry) -> Result<String, ScenarioError> {
    let is_line = |text: &&str| !text.trim().is_empty() && !text.contains(char::is_control);
    entry.value.as_str().filter(is_line).map(str::to_owned).ok_or_else(|| must(entry, "a text of one line"))
}

pub(crate) fn texts(entry: &Entry) -> Result<Vec<&str>, ScenarioError> {
    let texts =
        entry.value.as_array().and_then(|list| list.iter().map(toml::Value::as_str).collect::<Option<Vec<_>>>());
    texts.filter(|list| !list.is_empty()).ok_or_else(|| must(entry, "a list of names, as in [\"false_alarms\"]"))
}

/// The place of a quoted name in a list.
pub(crate) fn within(entry: &Entry, name: &str) -> Place {
    let Place { file, text, span } = entry.value_place.clone();
    let quoted = format!("\"{name}\"");
    let found = text.get(span.clone()).and_then(|list| list.rfind(&quoted));
    let span = found.map_or(span.clone(), |at| span.start + at..span.start + at + quoted.len());
    Place { file, text, span }
}
