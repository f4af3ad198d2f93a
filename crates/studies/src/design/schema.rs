use serde_json::{Value as Json, json};

use super::file::DESIGN_KEYS;
use super::quantity::Quantity;
use crate::compare::PERSONS;
use crate::sweep::sweep_schema;

/// JSON Schema draft 2020-12.
pub fn design_schema() -> Json {
    let about = |key: &str| DESIGN_KEYS.iter().find(|(known, _)| *known == key).map_or("", |(_, about)| *about);
    let with = |mut schema: Json, key: &str| {
        schema["description"] = json!(about(key));
        schema
    };
    let sweep = sweep_schema();
    let of_sweep = |name: &str| sweep["properties"][name].clone();
    let (mut patients, mut free) = (of_sweep("axes"), of_sweep("axes"));
    keep_forms(&mut patients, &|_| true);
    keep_forms(&mut free, &|form| form["properties"].get("median").is_none());
    let text = || json!({ "type": "string", "minLength": 1 });
    let whole = |least: u64| json!({ "type": "integer", "minimum": least });
    let share = || json!({ "type": "number", "minimum": 0, "maximum": 1 });
    let metric = || {
        json!({ "anyOf": [
            { "enum": Quantity::names().collect::<Vec<_>>() },
            { "pattern": "^(rupture|event)_[1-9][0-9]?_[a-z_0-9]+$" }
        ] })
    };
    let object =
        |properties: Json| json!({ "type": "object", "additionalProperties": false, "properties": properties });
    let by_name = |of: Json| json!({ "type": "object", "additionalProperties": of });
    let persons: Vec<&str> = PERSONS.iter().map(|person| person.name).collect();
    json!({
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "trocar design",
        "type": "object",
        "description": "Settings of a scenario that are best for a group of patients.",
        "additionalProperties": false,
        "required": ["free", "objectives"],
        "properties": {
            "name": with(text(), "name"),
            "question": with(text(), "question"),
            "base": with(text(), "base"),
            "population": with(text(), "population"),
            "persons": with(
                json!({ "type": "array", "minItems": 1, "uniqueItems": true, "items": { "enum": persons } }),
                "persons"
            ),
            "set": with(of_sweep("set"), "set"),
            "patients": with(patients, "patients"),
            "correlations": of_sweep("correlations"),
            "free": with(free, "free"),
            "objectives": by_name(object(json!({
                "minimise": with(metric(), "objectives.NAME.minimise"),
                "maximise": with(metric(), "objectives.NAME.maximise"),
                "quantile": with(share(), "objectives.NAME.quantile"),
            }))),
            "constraints": by_name(object(json!({
                "metric": with(metric(), "constraints.NAME.metric"),
                "at_least": with(json!({ "type": "number" }), "constraints.NAME.at_least"),
                "at_most": with(json!({ "type": "number" }), "constraints.NAME.at_most"),
                "quantile": with(share(), "constraints.NAME.quantile"),
                "certified": with(json!({ "const": true }), "constraints.NAME.certified"),
            }))),
            "training": object(json!({
                "patients": with(whole(1), "training.patients"),
                "seeds": with(whole(1), "training.seeds"),
                "seed": with(whole(0), "training.seed"),
            })),
            "validation": object(json!({
                "patients": with(whole(1), "validation.patients"),
                "seeds": with(whole(1), "validation.seeds"),
            })),
            "search": object(json!({
                "candidates": with(whole(4), "search.candidates"),
                "generations": with(whole(1), "search.generations"),
                "seed": with(whole(0), "search.seed"),
                "front": with(whole(1), "search.front"),
            })),
        }
    })
}

fn keep_forms(schema: &mut Json, is_kept: &dyn Fn(&Json) -> bool) {
    let Json::Object(schema) = schema else { return };
    if let Some(Json::Array(forms)) = schema.get_mut("anyOf") {
        forms.retain(|form| is_kept(form));
        for form in forms {
            if let Some(Json::Object(properties)) = form.get_mut("properties") {
                properties.remove("points");
            }
        }
        return;
    }
    schema.values_mut().for_each(|inner| keep_forms(inner, is_kept));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_free_key_has_ranges_without_points_and_no_distribution() {
        let schema = design_schema();
        let forms = |section: &str| {
            let key = &schema["properties"][section]["properties"]["augmentation"]["properties"]["min_hold_s"];
            let forms = key["anyOf"].as_array().expect("forms");
            forms.iter().map(|form| form["properties"].to_string()).collect::<Vec<_>>()
        };
        assert_eq!((forms("patients").len(), forms("free").len()), (3, 2));
        assert!(forms("patients").iter().all(|form| !form.contains("points")));
        let text = schema.to_string();
        let is_in = |(key, meaning): &&(&str, &str)| {
            key.starts_with("correlations.") || text.contains(&json!(meaning).to_string())
        };
        assert_eq!(DESIGN_KEYS.iter().find(|key| !is_in(key)), None);
    }
}
