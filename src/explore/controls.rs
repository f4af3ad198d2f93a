//! The data of a page's controls: every key that a page can set, with meaning, range and value.

use serde_json::{Value as Json, json};

use super::pair::PairMaker;
use super::protocol::ServerMessage;
use super::state::{Catalogue, SCHEME, State, StateError};
use trocar_sim::scenario::{KEYS, Key, Kind};
use trocar_sim::stability::Parameter;

/// Returns the first message to a page: scenarios, keys, and the parameters of a map.
pub(super) fn greeting(catalogue: &Catalogue, first: &str) -> ServerMessage {
    let scenarios: Vec<Json> =
        catalogue.entries().map(|(name, question)| json!({ "name": name, "question": question })).collect();
    let axes: Vec<Json> =
        Parameter::all().map(|parameter| json!({ "key": parameter.key(), "name": parameter.caption() })).collect();
    ServerMessage::json(&json!({
        "type": "hello",
        "version": env!("CARGO_PKG_VERSION"),
        "first": first,
        "scenarios": scenarios,
        "keys": KEYS.iter().filter(is_for_pages).map(description).collect::<Vec<_>>(),
        "axes": axes,
    }))
}

fn is_for_pages(key: &&Key) -> bool {
    !matches!(key.kind, Kind::File | Kind::Text) && key.path != SCHEME && key.path != "simulation.engine"
}

fn description(key: &Key) -> Json {
    let kind = match key.kind {
        Kind::Number(range) => json!({ "type": "number", "low": range.low().0, "high": range.high() }),
        Kind::Whole(min) => json!({ "type": "whole", "low": min }),
        Kind::Sign => json!({ "type": "choice", "choices": [1, -1] }),
        Kind::Numbers => json!({ "type": "numbers" }),
        Kind::Flag => json!({ "type": "flag" }),
        Kind::Choice(words) => json!({ "type": "choice", "choices": words }),
        Kind::Text | Kind::File => Json::Null,
    };
    json!({ "path": key.path, "kind": kind, "meaning": key.meaning, "must": key.kind.to_string() })
}

/// Returns the values of a scenario's keys.
///
/// # Errors
/// [`StateError`].
pub(super) fn values(id: u32, scenario: &str, maker: &mut PairMaker) -> Result<ServerMessage, StateError> {
    let state = State { scenario: scenario.to_owned(), ..State::default() };
    let written = maker.written(&state, true)?;
    let values = written.values();
    let given = KEYS.iter().filter(is_for_pages).filter_map(|key| {
        let value = serde_json::to_value(values.get(key.path)?.to_toml()).ok()?;
        Some((key.path.to_owned(), value))
    });
    Ok(ServerMessage::json(&json!({
        "type": "values",
        "id": id,
        "scenario": scenario,
        "name": written.name,
        "values": given.collect::<serde_json::Map<_, _>>(),
    })))
}
