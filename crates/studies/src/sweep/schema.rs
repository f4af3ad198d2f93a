use serde_json::{Map, Value as Json, json};

use super::columns::Column;
use super::design::SamplingScheme;
use super::file::SWEEP_KEYS;
use trocar_core::settings::{Key, Kind};
use trocar_engine::tissue::{LAYER_KEYS, LAYER_LIST};
use trocar_scenario::{KEYS, json_schema, number_schema};

/// JSON Schema draft 2020-12.
pub fn sweep_schema() -> Json {
    let about = |key: &str| SWEEP_KEYS.iter().find(|(known, _)| *known == key).map_or("", |(_, about)| *about);
    let names: Vec<String> = Column::names().collect();
    let metrics = json!({ "type": "array", "minItems": 1, "items": { "anyOf": [
        { "enum": names },
        { "pattern": "^(rupture|event)_[1-9][0-9]?_[a-z_0-9]+$" }
    ] } });
    let with = |mut schema: Json, key: &str| {
        schema["description"] = json!(about(key));
        schema
    };
    let points = || json!({ "type": "integer", "minimum": 1 });
    let mut set = json_schema();
    if let Json::Object(set) = &mut set {
        ["$schema", "title"].iter().for_each(|key| drop(set.remove(*key)));
        if let Some(Json::Object(properties)) = set.get_mut("properties") {
            properties.remove("base");
        }
    }
    let mut axes = json!({ "type": "object", "additionalProperties": false, "properties": {} });
    for key in KEYS.iter().filter(|key| !matches!(key.path, "name" | "simulation.seed")) {
        insert(&mut axes, &key.path.split('.').collect::<Vec<_>>(), axis(key));
    }
    let mut layer = json!({ "type": "object", "additionalProperties": false, "properties": {} });
    for key in LAYER_KEYS {
        insert(&mut layer, &[key.path.rsplit('.').next().unwrap_or(key.path)], axis(key));
    }
    let by_name = json!({ "type": "object", "additionalProperties": layer });
    insert(&mut axes, &LAYER_LIST.split('.').collect::<Vec<_>>(), by_name);
    json!({
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "trocar sweep",
        "type": "object",
        "description": "Many runs of a scenario with varied keys.",
        "additionalProperties": false,
        "required": ["base"],
        "properties": {
            "name": with(json!({ "type": "string", "minLength": 1 }), "name"),
            "question": with(json!({ "type": "string", "minLength": 1 }), "question"),
            "base": with(json!({ "type": "string", "minLength": 1 }), "base"),
            "seeds": with(
                json!({ "anyOf": [
                    points(),
                    { "type": "array", "minItems": 1, "uniqueItems": true, "items": { "type": "integer", "minimum": 0 } },
                ] }),
                "seeds"
            ),
            "first_seed": with(json!({ "type": "integer", "minimum": 0 }), "first_seed"),
            "metrics": with(metrics.clone(), "metrics"),
            "focus": with(metrics, "focus"),
            "csv": with(json!({ "type": "boolean" }), "csv"),
            "design": {
                "type": "object",
                "additionalProperties": false,
                "properties": {
                    "kind": with(json!({ "enum": SamplingScheme::WORDS }), "design.kind"),
                    "points": with(points(), "design.points"),
                    "seed": with(json!({ "type": "integer", "minimum": 0 }), "design.seed"),
                }
            },
            "set": with(set, "set"),
            "axes": axes,
            "correlations": { "type": "object", "additionalProperties": {
                "type": "object",
                "additionalProperties": false,
                "required": ["axes", "coefficient"],
                "properties": {
                    "axes": with(
                        json!({ "type": "array", "minItems": 2, "items": { "type": "string" } }),
                        "correlations.NAME.axes"
                    ),
                    "coefficient": with(
                        json!({ "type": "number", "exclusiveMinimum": -1, "exclusiveMaximum": 1 }),
                        "correlations.NAME.coefficient"
                    ),
                }
            } },
        }
    })
}

fn insert(schema: &mut Json, path: &[&str], property: Json) {
    let Some((first, rest)) = path.split_first() else { return };
    let Json::Object(properties) = &mut schema["properties"] else { return };
    if rest.is_empty() {
        properties.insert((*first).to_owned(), property);
    } else {
        let table = || json!({ "type": "object", "additionalProperties": false, "properties": {} });
        insert(properties.entry((*first).to_owned()).or_insert_with(table), rest, property);
    }
}

fn axis(key: &Key) -> Json {
    let (kind, meaning) = (key.kind, key.meaning);
    // A quantity may have a unit, as in "30ms".
    let number = || Json::Object(number_schema(key.path));
    let list = |items: Json| json!({ "type": "array", "minItems": 1, "items": items });
    let mut ways = vec![list(match kind {
        Kind::Number(_) => number(),
        Kind::Whole(_) => json!({ "type": "integer" }),
        Kind::Sign => json!({ "enum": [1, -1] }),
        Kind::Numbers => list(number()),
        Kind::Flag => json!({ "type": "boolean" }),
        Kind::Choice(words) => json!({ "enum": words }),
        Kind::Text | Kind::File => json!({ "type": "string" }),
    })];
    if matches!(kind, Kind::Number(_) | Kind::Whole(_)) {
        ways.push(json!({
            "type": "object",
            "additionalProperties": false,
            "required": ["from", "to"],
            "properties": {
                "from": number(),
                "to": number(),
                "points": { "type": "integer", "minimum": 2 },
                "log": { "type": "boolean" },
            }
        }));
    }
    if matches!(kind, Kind::Number(_)) {
        let mut median = number();
        median["exclusiveMinimum"] = json!(0);
        ways.push(json!({
            "type": "object",
            "additionalProperties": false,
            "required": ["median", "spread"],
            "properties": {
                "median": median,
                "spread": { "type": "number", "exclusiveMinimum": 1, "maximum": 10 },
            }
        }));
    }
    let mut map = Map::new();
    map.insert("description".into(), json!(meaning));
    map.insert("anyOf".into(), Json::Array(ways));
    Json::Object(map)
}
