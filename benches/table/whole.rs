//! A whole tick: a single run from a ready engine.

use trocar::engine::{ExactPlants, Wired};
use trocar::metrics::MetricsObserver;
use trocar::scenario::Scenario;

use crate::timing::{Cost, elapsed_s, time_ns};

/// Returns the engine of a scenario and an observer for it.
pub fn ready(scenario: &Scenario) -> (Wired<f64, ExactPlants<f64>>, MetricsObserver<f64>) {
    let engine = scenario.exact_engine(0).expect("a shipped scenario builds");
    (engine, MetricsObserver::new(scenario.grid, scenario.rupture_times_s().len()))
}

/// Measures a tick without metrics, in ns.
pub fn bare_ns(scenario: &Scenario) -> Cost {
    let (engine, _) = ready(scenario);
    time_ns(scenario.grid.ticks() as f64, || {
        let mut engine = engine.clone();
        elapsed_s(|| engine.run_compiled(&mut ()).expect("runs"))
    })
}

/// Measures a tick with metrics, in ns.
pub fn full_ns(scenario: &Scenario) -> Cost {
    let (engine, observer) = ready(scenario);
    time_ns(scenario.grid.ticks() as f64, || {
        let (mut engine, mut observer) = (engine.clone(), observer.clone());
        elapsed_s(|| engine.run_compiled(&mut observer).expect("runs"))
    })
}
