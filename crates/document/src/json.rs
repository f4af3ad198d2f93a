//! JSON files.

use serde_json::Value as Json;

/// Returns a value as text, indented and with a line feed at the end: the content of a JSON file, which `--json` prints.
#[must_use]
pub fn to_json(value: &Json) -> String {
    format!("{value:#}\n")
}
