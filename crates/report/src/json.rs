//! The JSON files. An undefined value is `null`.

use serde::Serialize;
use serde_json::Value as Json;

/// Returns a value in the format of the JSON files.
#[must_use]
pub fn to_json(value: &Json) -> String {
    render(value)
}

/// Returns indented JSON with a final line feed.
pub(super) fn render(value: &impl Serialize) -> String {
    // Maps with text keys and numbers do not fail to serialise.
    let mut text = serde_json::to_string_pretty(value).unwrap_or_default();
    text.push('\n');
    text
}
