//! Runs scenarios for their metrics and trace; `trocar-studies` judges and describes runs. The crate `trocar`
//! re-exports this one as `trocar::run`.
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

/// Runs a scenario with its trace, reproducible bit for bit; missed ruptures and sustained oscillations are explained,
/// if necessary by further runs. A run that diverges is a result, not an error.
pub fn run(scenario: Scenario) -> Result<Run, RunError> {
    let mut trace = empty_trace(&scenario);
    let metrics = observe(&scenario, &mut trace.recorder())?;
    Run::concluded(scenario, metrics, trace)
}

impl Run {
    /// Adds names of ruptured layers, a sustained oscillation and the reasons of misses.
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

    /// For a run with user-defined parts in some roles ([`UserDefinedParts::roles`]).
    ///
    /// It cannot be repeated, so a rupture's layer, a miss's reason and an oscillation's cause remain unknown; the
    /// warnings report this where it matters.
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

/// The observer is not called for a diverged tick.
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
