//! The JSON files. An undefined value is `null`.

use serde::Serialize;
use serde_json::{Value as Json, json};

use trocar_detect::DetectionReport;
use trocar_scenario::Values;

/// Returns the content of `detection.json`: the alarms, the statistics of the estimates, the scores and the settings.
#[must_use]
pub fn detection_object(name: &str, report: &DetectionReport, values: &Values) -> Json {
    let settings: serde_json::Map<String, Json> = ["estimator", "detector"]
        .into_iter()
        .map(|section| (section.to_owned(), values.section_json(section)))
        .collect();
    let mut all = json!({
        "trocar_version": env!("CARGO_PKG_VERSION"),
        "recording": name,
        "settings": settings,
    });
    if let (Json::Object(all), Ok(Json::Object(report))) = (&mut all, serde_json::to_value(report)) {
        all.extend(report);
    }
    all
}

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
