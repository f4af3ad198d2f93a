//! The meaning, range and value of every key that a page can set.

use serde_json::{Value as Json, json};

use super::pair::PairMaker;
use super::protocol::ServerMessage;
use super::state::{Catalogue, Entry, SCHEME, State, StateError};
use trocar_scenario::{KEYS, KeyAt, Kind, unit_of};
use trocar_stability::Parameter;

pub(super) fn greeting(catalogue: &Catalogue, first: &str) -> ServerMessage {
    let scenarios: Vec<Entry> = catalogue.entries().collect();
    let axes: Vec<Json> =
        Parameter::all().map(|parameter| json!({ "key": parameter.key(), "name": parameter.caption() })).collect();
    ServerMessage::json(&json!({
        "type": "hello",
        "version": env!("CARGO_PKG_VERSION"),
        "first": first,
        "scenarios": scenarios,
        "keys": KEYS.iter().map(KeyAt::from).filter(is_for_pages).map(|key| description(&key)).collect::<Vec<_>>(),
        "axes": axes,
    }))
}

fn is_for_pages(key: &KeyAt) -> bool {
    // Runs do not depend on a population.
    let is_of_runs = key.path != "simulation.engine" && !key.path.starts_with("population.");
    !matches!(key.kind, Kind::File | Kind::Text) && key.path != SCHEME && is_of_runs
}

fn description(key: &KeyAt) -> Json {
    let kind = match key.kind {
        Kind::Number(range) => json!({ "type": "number", "low": range.low().0, "high": range.high() }),
        Kind::Whole(min) => json!({ "type": "whole", "low": min }),
        Kind::Sign => json!({ "type": "choice", "choices": [1, -1] }),
        Kind::Numbers => json!({ "type": "numbers" }),
        Kind::Flag => json!({ "type": "flag" }),
        Kind::Choice(words) => json!({ "type": "choice", "choices": words }),
        Kind::Text | Kind::File => Json::Null,
    };
    // The conditions let a page disable controls without effect.
    let acts = key.acts_for.into_iter().flat_map(|acts| acts.conditions());
    let acts: Vec<Json> = acts.map(|acts| json!({ "key": acts.key, "words": acts.words() })).collect();
    let name = plain_name(&key.path);
    json!({ "path": key.path, "name": name, "unit": unit_of(&key.path), "kind": kind, "meaning": key.meaning, "acts": acts })
}

/// The name of a key in words, without its unit: `skin: rupture force`.
fn plain_name(path: &str) -> String {
    let (section, name) = path.rsplit_once('.').unwrap_or(("", path));
    let units = ["n", "n2", "j", "hz", "m", "s", "kg", "m2", "s2", "per"];
    let mut words: Vec<&str> = name.split('_').collect();
    while words.len() > 1 && unit_of(path).is_some() && words.last().is_some_and(|word| units.contains(word)) {
        words.pop();
    }
    let section = section.rsplit('.').next().unwrap_or_default();
    if section.is_empty() { words.join(" ") } else { format!("{section}: {}", words.join(" ")) }
}

pub(super) fn values(id: u32, scenario: &str, maker: &mut PairMaker) -> Result<ServerMessage, StateError> {
    let state = State { scenario: scenario.to_owned(), ..State::default() };
    let written = maker.written(&state, true)?;
    let values = written.values();
    let layers = || values.layer_keys();
    let given = KEYS.iter().map(KeyAt::from).filter(is_for_pages).chain(layers()).filter_map(|key| {
        let value = serde_json::to_value(values.get(&key.path)?.to_toml()).ok()?;
        Some((key.path.into_owned(), value))
    });
    Ok(ServerMessage::json(&json!({
        "type": "values",
        "id": id,
        "scenario": scenario,
        "name": written.name,
        "layers": layers().map(|key| description(&key)).collect::<Vec<_>>(),
        "values": given.collect::<serde_json::Map<_, _>>(),
    })))
}
