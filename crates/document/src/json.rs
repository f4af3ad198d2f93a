use schemars::generate::SchemaSettings;
use schemars::{JsonSchema, Schema};
use serde::Serialize;
use serde_json::Value as Json;

/// Indented, with a line feed at the end, as `--json` prints it.
pub fn to_json(value: &Json) -> String {
    format!("{value:#}\n")
}

/// Non-finite numbers become `null`. Panics if the keys of a map are not strings.
pub fn json_of(content: &impl Serialize) -> Json {
    serde_json::to_value(content).expect("keys are strings")
}

/// Draft 2020-12. Objects allow only the keys of their type.
pub fn schema_of<T: JsonSchema>() -> Json {
    let generator = SchemaSettings::draft2020_12().for_serialize().into_generator();
    let mut schema = generator.into_root_schema_for::<T>().to_value();
    complete(&mut schema, true);
    // A `Schema` serialises its keywords in a fixed order.
    Schema::try_from(schema).map(|schema| json_of(&schema)).unwrap_or_default()
}

/// A part must not forbid unknown keys itself.
fn complete(schema: &mut Json, is_whole: bool) {
    let Json::Object(map) = schema else { return };
    let has_properties = map.contains_key("properties");
    let mut is_combined = false;
    for (keyword, value) in map.iter_mut() {
        match (keyword.as_str(), value) {
            ("description", Json::String(text)) => *text = text.replace('\n', " ").replace("`None`", "`null`"),
            ("allOf" | "anyOf" | "oneOf", Json::Array(parts)) => {
                is_combined = true;
                parts.iter_mut().for_each(|part| complete(part, is_whole && !has_properties));
            }
            ("properties" | "$defs", Json::Object(parts)) => parts.values_mut().for_each(|part| complete(part, true)),
            ("prefixItems", Json::Array(parts)) => parts.iter_mut().for_each(|part| complete(part, true)),
            ("items" | "additionalProperties", part) => complete(part, true),
            _ => {}
        }
    }
    if has_properties && is_whole {
        let keyword = if is_combined { "unevaluatedProperties" } else { "additionalProperties" };
        map.insert(keyword.to_owned(), false.into());
    }
}
