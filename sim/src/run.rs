//! Running a scenario: its metrics, and its trace where wanted.

mod pack;

pub(crate) use pack::{Asked, run_pack_asking};
pub use pack::{PACK, can_share, run_pack, run_pack_in, run_pack_sharing};

use thiserror::Error;

use crate::engine::{IntegrationError, Observer, Trace};
use crate::metrics::{LinkMetrics, Metrics, MetricsObserver};
use crate::scenario::{Scenario, ScenarioEngine, ScenarioError};

/// A scenario that was run.
#[derive(Debug, Clone)]
pub struct Run {
    /// What was run.
    pub scenario: Scenario,
    /// What it was worth.
    pub metrics: Metrics,
    /// Every tick of it.
    pub trace: Trace,
}

/// Why a scenario could not be run to a result.
#[derive(Debug, Error)]
pub enum RunError {
    /// The scenario cannot be run as written.
    #[error(transparent)]
    Scenario(#[from] ScenarioError),
    /// The numerical integration gave up.
    #[error("{name}: {source}")]
    Integration {
        /// The scenario's name.
        name: String,
        /// What the integrator says.
        source: IntegrationError,
    },
}

/// Runs a scenario and keeps its trace. The same scenario gives the same bits.
///
/// # Errors
/// [`RunError`]; a run that diverges is a result, not an error.
pub fn run(scenario: Scenario) -> Result<Run, RunError> {
    let mut trace =
        Trace::new(scenario.grid).with_extra_parameter(scenario.estimator.parameters.extra_parameter_column());
    let metrics = observe(&scenario, &mut trace)?;
    Ok(Run { scenario, metrics, trace })
}

/// Runs a scenario for its metrics.
///
/// # Errors
/// As [`run`].
pub fn measure(scenario: &Scenario) -> Result<Metrics, RunError> {
    measure_asking(scenario, &[]).map(|asked| asked.metrics)
}

/// [`measure`], and which of some higher thresholds, below the detector's cap, the run is the same under.
fn measure_asking(scenario: &Scenario, higher: &[f64]) -> Result<Asked, RunError> {
    let mut alike = vec![];
    let metrics = with_metrics(scenario, |engine, metrics| {
        if !higher.is_empty() {
            engine.ask_higher_thresholds(higher);
        }
        engine.run(metrics)?;
        alike = engine.thresholds_alike();
        Ok(())
    })?;
    Ok(Asked { metrics, alike })
}

/// Runs a scenario for its metrics, under the eyes of one more observer, which does not see a diverged tick.
///
/// # Errors
/// As [`run`].
pub fn observe(scenario: &Scenario, observer: &mut dyn Observer<f64>) -> Result<Metrics, RunError> {
    with_metrics(scenario, |engine, metrics| engine.run(&mut (metrics, observer)))
}

fn with_metrics(
    scenario: &Scenario,
    run: impl FnOnce(&mut ScenarioEngine, &mut MetricsObserver<f64>) -> Result<(), IntegrationError>,
) -> Result<Metrics, RunError> {
    let mut metrics = MetricsObserver::new(scenario.grid, scenario.rupture_times_s().len());
    let mut engine = scenario.build()?;
    run(&mut engine, &mut metrics).map_err(|source| RunError::Integration { name: scenario.name.clone(), source })?;
    let link = engine.link_report().map(|report| LinkMetrics::new(&report, &scenario.grid));
    Ok(Metrics { link, ..metrics.metrics(0) })
}
