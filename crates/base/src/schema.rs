use std::borrow::Cow;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};

use crate::warning::Code;

impl JsonSchema for Code {
    fn schema_name() -> Cow<'static, str> {
        "Code".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        let codes = Self::ALL.iter().map(|code| json_schema!({ "const": code.word(), "description": code.meaning() }));
        json_schema!({ "description": "The code of a warning.", "oneOf": codes.collect::<Vec<_>>() })
    }
}
