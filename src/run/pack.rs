//! Running neighbouring cases together.

use super::{RunError, observe};
use crate::metrics::Metrics;
use crate::scenario::Scenario;

/// Runs up to eight scenarios for their metrics, each as if alone, in their order.
#[must_use]
pub fn run_pack(scenarios: &[Scenario]) -> Vec<Result<Metrics, RunError>> {
    scenarios.iter().map(|scenario| observe(scenario, &mut ())).collect()
}
