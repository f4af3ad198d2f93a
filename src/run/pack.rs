//! Several scenarios side by side.

use super::{RunError, observe};
use crate::metrics::Metrics;
use crate::scenario::Scenario;

/// Runs scenarios for their metrics, in their order, side by side where they can be: each gives the bits that it gives alone.
///
/// A scenario that cannot be run is an error at its own place and no hindrance to the others.
pub fn run_pack(scenarios: &[Scenario]) -> Vec<Result<Metrics, RunError>> {
    scenarios.iter().map(|scenario| observe(scenario, &mut ())).collect()
}
