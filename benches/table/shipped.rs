//! The shipped scenarios.

use trocar::scenario::{Scenario, Source};

pub fn scenario(name: &str) -> Scenario {
    scenario_with(name, &[])
}

/// Loads a shipped scenario with settings, each `section.key=value`.
pub fn scenario_with(name: &str, settings: &[&str]) -> Scenario {
    let path = format!("builtin:{name}");
    let settings: Vec<String> = settings.iter().map(|&setting| setting.to_owned()).collect();
    Scenario::load(&Source::parse(&path), &settings).expect("a shipped scenario loads")
}
