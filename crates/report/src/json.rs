//! The JSON files. An undefined value is `null`.

use serde::Serialize;
use serde_json::{Value as Json, json};

use trocar_detect::ExtraParameterEstimate;
use trocar_studies::compare::{Comparison, Fact, SchemeStudy, SeedStudy};
use trocar_studies::run::{Run, seeds_without_effect};

/// Returns `summary.json` of a run: every metric, the events, the seed and the version.
#[must_use]
pub fn summary_json(run: &Run) -> String {
    render(&run_object(run))
}

/// Returns the content of [`summary_json`].
#[must_use]
pub fn run_object(run: &Run) -> Json {
    let mut all = json!({
        "trocar_version": env!("CARGO_PKG_VERSION"),
        "scenario": run.scenario.name,
        "seed": run.scenario.seed,
        "tick_s": run.scenario.grid.tick_s(),
        "warnings": run.warnings(),
        "metrics": run.metrics,
    });
    if let (Json::Object(all), Some(estimate)) = (&mut all, ExtraParameterEstimate::of(&run.trace.extra_parameter)) {
        all.insert("further_estimate".into(), json!(estimate));
    }
    all
}

/// Returns `comparison.json`: the summaries, the table, the detection in noise, the paper's facts for the shipped pair, and
/// the study over seeds, if any.
#[must_use]
pub fn comparison_json(comparison: &Comparison, facts: Option<&[Fact]>, study: Option<&SeedStudy>) -> String {
    render(&comparison_object(comparison, facts, study))
}

/// Returns the content of `comparison.json` of a scenario with every passivity scheme: as that of a comparison, and a row per
/// scheme.
#[must_use]
pub fn schemes_json(study: &SchemeStudy, seeds: Option<&SeedStudy>) -> String {
    let mut all = comparison_object(&study.comparison, None, seeds);
    if let Json::Object(all) = &mut all {
        all.insert("schemes".into(), json!(study.rows));
    }
    render(&all)
}

fn comparison_object(comparison: &Comparison, facts: Option<&[Fact]>, study: Option<&SeedStudy>) -> Json {
    let scenarios = comparison.runs.iter().map(|run| &run.scenario);
    let of_seeds = seeds_without_effect(scenarios, study.map_or(1, |study| study.seeds));
    let warnings: Vec<_> = of_seeds.into_iter().chain(comparison.warnings()).collect();
    let mut all = json!({
        "trocar_version": env!("CARGO_PKG_VERSION"),
        "runs": comparison.runs.iter().map(run_object).collect::<Vec<_>>(),
        "warnings": warnings,
        "table": comparison.table(),
        "noise": comparison.noise,
        "paper_facts": facts,
    });
    if let (Json::Object(all), Some(study)) = (&mut all, study) {
        all.insert("seeds".into(), json!(study));
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
