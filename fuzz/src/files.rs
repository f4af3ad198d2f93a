//! Scenarios, sweeps, labels and frequency responses.

use std::sync::Arc;

use trocar_recording::{Limits, open_labels};
use trocar_scenario::{Scenario, Source};
use trocar_studies::sweep::Plan;

fn source(content: &[u8]) -> Source {
    Source::Text { name: Arc::from("fuzz.toml"), text: Arc::from(String::from_utf8_lossy(content)) }
}

/// True if a text has a key for a file, such as `recording.file`, which would be read.
fn names_files(content: &[u8]) -> bool {
    content.windows(4).any(|word| word == b"file")
}

pub fn scenario(content: &[u8]) {
    if names_files(content) {
        return;
    }
    match Scenario::load(&source(content), &[]) {
        // The echo of a valid scenario is a valid scenario.
        Ok(scenario) => {
            Scenario::load(&source(scenario.echo().as_bytes()), &[]).expect("the echo is valid");
        }
        Err(error) => assert!(error.to_string().len() < 100_000, "a long message"),
    }
}

pub fn sweep(content: &[u8]) {
    if names_files(content) {
        return;
    }
    match Plan::load(&source(content), &[]) {
        Ok(plan) => {
            let cases = plan.design.cases();
            // A case can be invalid, but must not panic.
            let _ = plan.scenario(cases / 2);
        }
        Err(error) => assert!(error.to_string().len() < 100_000, "a long message"),
    }
}

pub fn tables(content: &[u8]) {
    let path = std::env::temp_dir().join(format!("trocar-fuzz-{}.csv", std::process::id()));
    std::fs::write(&path, content).expect("the file can be written");
    let _ = open_labels(&path, &Limits::default(), true);
    let _ = trocar_recording::open_response(&path, &Limits::default());
}
