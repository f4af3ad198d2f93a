use serde_json::{Map, Value as Json, json};
use trocar_core::settings::{Fallback, Key, Kind};

use super::key_table::{KEYS, SECTIONS};
use super::layers::{NAME_PATTERN, field};
use super::quantity::unit_of;
use super::value::Value;
use trocar_engine::tissue::{LAYER_KEYS, LAYER_LIST};

/// JSON Schema draft 2020-12.
pub fn json_schema() -> Json {
    let mut root = table("A scenario of trocar: one simulated needle insertion.");
    let base = json!({ "type": "string", "description": "A scenario to inherit from: a path relative to this file, or the name of a shipped one." });
    insert(&mut root, &["base"], base);
    for (path, about) in SECTIONS {
        insert(&mut root, &path.split('.').collect::<Vec<_>>(), table(about));
    }
    for key in KEYS {
        insert(&mut root, &key.path.split('.').collect::<Vec<_>>(), property(key));
    }
    insert(&mut root, &LAYER_LIST.split('.').collect::<Vec<_>>(), layers());
    if let Json::Object(map) = &mut root {
        map.insert("$schema".into(), json!("https://json-schema.org/draft/2020-12/schema"));
        map.insert("title".into(), json!("trocar scenario"));
    }
    root
}

fn layers() -> Json {
    let mut layer = table("A layer.");
    for key in LAYER_KEYS {
        insert(&mut layer, &[field(key.path)], property(key));
    }
    let mut item = layer.clone();
    insert(
        &mut item,
        &["name"],
        json!({ "type": "string", "pattern": NAME_PATTERN, "description": "Name of the layer." }),
    );
    item["required"] = json!(["name"]);
    let list = json!({ "type": "array", "minItems": 1, "items": item });
    let by_name = json!({ "type": "object", "additionalProperties": layer });
    json!({ "description": "The layers of the tissue, from the surface down.", "anyOf": [list, by_name] })
}

fn table(about: &str) -> Json {
    json!({ "type": "object", "description": about, "additionalProperties": false, "properties": {} })
}

fn insert(schema: &mut Json, path: &[&str], property: Json) {
    let Some((first, rest)) = path.split_first() else { return };
    let properties = &mut schema["properties"];
    if rest.is_empty() {
        properties[*first] = property;
    } else {
        insert(&mut properties[*first], rest, property);
    }
}

/// Such as "30ms" or "-2.5e-1 N/mm"; the unit is unchecked.
const QUANTITY_PATTERN: &str = r"^\s*[+-]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][+-]?[0-9]+)?\s*[^0-9\s.].*$";

/// A key with a unit also accepts a text with a number and a unit.
pub fn number_schema(path: &str) -> Map<String, Json> {
    let mut map = Map::new();
    if unit_of(path).is_some() {
        map.insert("type".into(), json!(["number", "string"]));
        map.insert("pattern".into(), json!(QUANTITY_PATTERN));
    } else {
        map.insert("type".into(), json!("number"));
    }
    map
}

fn property(key: &Key) -> Json {
    let mut map = Map::new();
    let mut put = |name: &str, value: Json| map.insert(name.into(), value);
    match key.kind {
        Kind::Number(range) => {
            number_schema(key.path).into_iter().for_each(|(name, value)| drop(put(&name, value)));
            let (low, open) = range.low();
            put(if open { "exclusiveMinimum" } else { "minimum" }, json!(low));
            put("maximum", json!(range.high()));
        }
        Kind::Whole(min) => {
            put("type", json!("integer"));
            put("minimum", json!(min));
        }
        Kind::Sign => {
            put("enum", json!([1, -1]));
        }
        Kind::Numbers => {
            put("type", json!("array"));
            put("items", Json::Object(number_schema(key.path)));
        }
        Kind::Flag => {
            put("type", json!("boolean"));
        }
        Kind::Choice(words) => {
            put("enum", json!(words));
        }
        Kind::Text | Kind::File => {
            put("type", json!("string"));
            let may_be_empty = matches!((key.kind, key.fallback), (Kind::Text, Fallback::Unset));
            put("minLength", json!(u8::from(!may_be_empty)));
        }
    }
    let mut meaning = key.meaning.to_owned();
    match key.fallback {
        Fallback::Value(value) => {
            let default = serde_json::to_value(Value::from(value).to_toml()).unwrap_or(Json::Null);
            put("default", default);
        }
        Fallback::Derived(rule) => meaning.push_str(&format!(" Default: {rule}.")),
        Fallback::Unset => {}
    }
    put("description", json!(meaning));
    Json::Object(map)
}
