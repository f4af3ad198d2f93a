//! The JSON files. An undefined value is `null`, never 0.

use serde::Serialize;
use serde_json::{Value as Json, json};

use crate::compare::{Comparison, Fact, SeedStudy};
use crate::detect::DetectionReport;
use crate::run::Run;
use crate::scenario::Values;

/// `summary.json` of a run: every metric, the events, the seed and the version.
#[must_use]
pub fn summary_json(run: &Run) -> String {
    render(&summary(run))
}

fn summary(run: &Run) -> Json {
    json!({
        "trocar_version": env!("CARGO_PKG_VERSION"),
        "scenario": run.scenario.name,
        "seed": run.scenario.seed,
        "tick_s": run.scenario.grid.tick_s(),
        "metrics": run.metrics,
    })
}

/// `comparison.json`: the summaries, the table, the detection in noise, for the shipped pair the paper's facts, and the
/// spread over seeds where one was asked for.
#[must_use]
pub fn comparison_json(comparison: &Comparison, facts: Option<&[Fact]>, study: Option<&SeedStudy>) -> String {
    let mut all = json!({
        "trocar_version": env!("CARGO_PKG_VERSION"),
        "runs": comparison.runs.iter().map(summary).collect::<Vec<_>>(),
        "table": comparison.table(),
        "noise": comparison.noise,
        "paper_facts": facts,
    });
    if let (Json::Object(all), Some(study)) = (&mut all, study) {
        all.insert("seeds".into(), json!(study));
    }
    render(&all)
}

/// `detection.json`: the alarms, the residual's statistics and the settings.
#[must_use]
pub fn detection_json(name: &str, report: &DetectionReport, values: &Values) -> String {
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
    render(&all)
}

/// Indented, with a final line end.
pub(super) fn render(value: &impl Serialize) -> String {
    // Maps with text keys and numbers do not fail to serialise.
    let mut text = serde_json::to_string_pretty(value).unwrap_or_default();
    text.push('\n');
    text
}
