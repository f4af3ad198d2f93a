//! Runs scenarios for their metrics, and optionally their trace.
//!
//! It does not judge or describe a run; `trocar-studies` does. The crate `trocar` re-exports it as `trocar::run`.
mod at_rest;
mod checked_parts;
mod misses;
mod oscillation;
mod pack;
mod reach;
mod stepped;
mod swings;

#[doc(hidden)]
pub use oscillation::{Swing, lasting_swing};
pub use pack::{PACK, can_share, run_pack, run_pack_in, run_pack_sharing};
#[doc(hidden)]
pub use pack::{RunObserver, run_pack_observed};
pub use reach::Reach;
pub use stepped::SteppedRun;
pub use trocar_scenario::{empty_trace, empty_trace_with};

use thiserror::Error;

use checked_parts::CheckedParts;

use trocar_engine::engine::{EngineError, Observer, Trace, UserDefinedParts, Wiring};
use trocar_engine::teleoperation::LinkReport;
use trocar_metrics::{LinkMetrics, Metrics, MetricsObserver, PortColumns, PortMetrics};
use trocar_scenario::{Scenario, ScenarioError};

#[derive(Debug, Clone)]
pub struct Run {
    pub scenario: Scenario,
    pub metrics: Metrics,
    pub trace: Trace,
    /// `None` without a trace.
    pub reach: Option<Reach>,
    /// With a user-defined part.
    pub user_defined_parts: Vec<&'static str>,
}

#[derive(Debug, Error)]
pub enum RunError {
    #[error(transparent)]
    Scenario(#[from] ScenarioError),
    /// The numerical integration or a user-defined part failed.
    #[error("{name}: {source}")]
    Engine { name: String, source: EngineError },
}

/// Runs a scenario and records its trace. Results are reproducible bit for bit.
///
/// Missed ruptures and sustained oscillations are explained from the trace and, if necessary, further runs.
///
/// # Errors
/// [`RunError`]; a run that diverges is a result, not an error.
pub fn run(scenario: Scenario) -> Result<Run, RunError> {
    let mut trace = empty_trace(&scenario);
    let metrics = observe(&scenario, &mut trace.recorder())?;
    Run::concluded(scenario, metrics, trace)
}

impl Run {
    /// Adds the names of the ruptured layers, a sustained oscillation and the reasons of missed ruptures.
    pub fn concluded(scenario: Scenario, mut metrics: Metrics, trace: Trace) -> Result<Self, RunError> {
        metrics.outcome = oscillation::outcome(&scenario, &trace, metrics.outcome)?;
        misses::explain_misses(&scenario, &mut metrics)?;
        for (rupture, layer) in metrics.ruptures.iter_mut().zip(scenario.rupturing_layers()) {
            rupture.layer = Some(layer.to_owned());
        }
        metrics.ports = port_metrics(&scenario, &trace);
        let reach = Reach::of(&scenario.grid, &metrics, &trace);
        Ok(Self { scenario, metrics, trace, reach, user_defined_parts: vec![] })
    }

    /// Combines a scenario with the metrics and the trace of a run with user-defined parts in some roles
    /// ([`UserDefinedParts::roles`]).
    ///
    /// Such a run cannot be repeated, so the layer of a rupture, the reason of a miss and the cause of an oscillation
    /// remain unknown. The warnings about a run report this where it matters.
    pub fn of_user_defined_parts(
        scenario: Scenario,
        user_defined_parts: Vec<&'static str>,
        mut metrics: Metrics,
        trace: Trace,
    ) -> Self {
        metrics.ports = port_metrics(&scenario, &trace);
        let reach = Reach::of(&scenario.grid, &metrics, &trace);
        Self { scenario, metrics, trace, reach, user_defined_parts }
    }
}

pub fn run_with(scenario: Scenario, parts: UserDefinedParts) -> Result<Run, RunError> {
    let roles = parts.roles();
    if roles.is_empty() {
        return run(scenario);
    }
    let mut trace = empty_trace_with(&scenario, &parts);
    let metrics = observe_with(&scenario, parts, &mut trace.recorder())?;
    Ok(Run::of_user_defined_parts(scenario, roles, metrics, trace))
}

pub fn measure(scenario: &Scenario) -> Result<Metrics, RunError> {
    let mut engine = scenario.build()?;
    let metrics = with_metrics(scenario, (), |observers| engine.run_compiled(observers))?;
    Ok(with_link(scenario, metrics, engine.link_report()))
}

/// The additional observer is not called for a diverged tick.
pub fn observe(scenario: &Scenario, observer: &mut dyn Observer<f64>) -> Result<Metrics, RunError> {
    let mut engine = scenario.build()?;
    let metrics = with_metrics(scenario, observer, |observers| engine.run(observers))?;
    Ok(with_link(scenario, metrics, engine.link_report()))
}

pub fn observe_with(
    scenario: &Scenario,
    parts: UserDefinedParts,
    observer: &mut dyn Observer<f64>,
) -> Result<Metrics, RunError> {
    let checked = CheckedParts::new(parts.roles(), scenario.grid);
    let mut engine = scenario.build_with(parts)?;
    let mut observers = (checked, (metrics_observer(scenario), observer));
    let outcome = engine.run_compiled(&mut observers);
    let (checked, (metrics, _)) = observers;
    checked_outcome(scenario, &checked, outcome)?;
    Ok(with_link(scenario, metrics.metrics(0), engine.parts.link_report(0)))
}

fn checked_outcome(
    scenario: &Scenario,
    checked: &CheckedParts,
    outcome: Result<(), EngineError>,
) -> Result<(), RunError> {
    let outcome = checked.outcome().map_err(EngineError::from).and(outcome);
    outcome.map_err(|source| RunError::Engine { name: scenario.name.clone(), source })
}

fn with_metrics<O: Observer<f64>>(
    scenario: &Scenario,
    observer: O,
    run: impl FnOnce(&mut (MetricsObserver<f64>, O)) -> Result<(), EngineError>,
) -> Result<Metrics, RunError> {
    let mut observers = (metrics_observer(scenario), observer);
    run(&mut observers).map_err(|source| RunError::Engine { name: scenario.name.clone(), source })?;
    Ok(observers.0.metrics(0))
}

fn metrics_observer(scenario: &Scenario) -> MetricsObserver<f64> {
    let metrics = MetricsObserver::new(scenario.grid, scenario.rupture_times_s().len());
    metrics.of_operators(|_| scenario.operator_traits())
}

fn with_link(scenario: &Scenario, metrics: Metrics, report: Option<LinkReport>) -> Metrics {
    Metrics { link: report.map(|report| LinkMetrics::new(&report, &scenario.grid)), ..metrics }
}

/// `None` if they are undefined.
#[doc(hidden)]
pub fn ports(scenario: &Scenario) -> Result<Option<PortMetrics>, RunError> {
    let mut trace = empty_trace(scenario);
    observe(scenario, &mut trace.recorder())?;
    Ok(port_metrics(scenario, &trace))
}

fn port_metrics(scenario: &Scenario, trace: &Trace) -> Option<PortMetrics> {
    let columns = PortColumns {
        time_s: &trace.time_s,
        needle_m: &trace.slave_position_m,
        hand_j: &trace.hand_energy_j,
        master_j: &trace.master_energy_j,
        reference_j: &trace.reference_energy_j,
        needle_j: &trace.needle_energy_j,
    };
    PortMetrics::of(&columns, scenario.link.machines.energy_scale())
}
