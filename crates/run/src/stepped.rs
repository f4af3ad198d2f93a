use std::ops::ControlFlow;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use super::checked_parts::CheckedParts;
use super::{Run, RunError, checked_outcome, empty_trace_with, metrics_observer, with_link};
use trocar_core::augmentation::Mode;
use trocar_engine::engine::{BuiltInOr, Trace, UserDefinedEngine, UserDefinedParts, Wiring};
use trocar_engine::operator::{HumanOperator, Operator};
use trocar_metrics::{Metrics, MetricsObserver};
use trocar_scenario::{Scenario, ScenarioError, TissueRange};

/// A run that its caller advances tick by tick, optionally with the position of a person or another program.
///
/// ```
/// # mod trocar {
/// #     pub use {trocar_engine::engine, trocar_scenario as scenario, trocar_run as run};
/// # }
/// use trocar::engine::UserDefinedParts;
/// use trocar::run::SteppedRun;
/// use trocar::scenario::{Scenario, Source};
///
/// let mut run = SteppedRun::new(Scenario::load(&Source::parse("layers/skin-augmented"), &[])?, UserDefinedParts::default())?;
/// while run.step(None)? {
///     // The signals of the tick are the last ones of the trace.
///     if run.trace().tissue_force_n.last().is_some_and(|force_n| *force_n > 1.0) {
///         break;
///     }
/// }
/// // The person stops here.
/// let here_m = run.trace().master_position_m.last().copied();
/// while run.step(here_m)? {}
/// assert!(run.conclude().metrics.ruptures.is_empty());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct SteppedRun {
    scenario: Scenario,
    engine: UserDefinedEngine,
    observers: (CheckedParts, (MetricsObserver<f64>, Trace)),
    led: Arc<AtomicU64>,
    desired_m: f64,
    led_m: Vec<f64>,
    has_ended: bool,
}

impl SteppedRun {
    pub fn new(scenario: Scenario, parts: UserDefinedParts) -> Result<Self, RunError> {
        let trace = empty_trace_with(&scenario, &parts);
        let mut roles = parts.roles();
        if parts.operator.is_none() {
            roles.push("operator");
        }
        let mut engine = scenario.build_with(parts)?;
        let led = Arc::new(AtomicU64::new(f64::NAN.to_bits()));
        let operator = Led { operator: engine.parts.operator, led: led.clone() };
        engine.parts.operator = BuiltInOr::UserDefined(Box::new(operator));
        let desired_m = engine.parts.begin();
        let checked = CheckedParts::new(roles, scenario.grid);
        let observers = (checked, (metrics_observer(&scenario), trace));
        Ok(Self { scenario, engine, observers, led, desired_m, led_m: vec![], has_ended: false })
    }

    /// Repeats a run without user-defined parts from its [`SteppedRun::led_m`], and continues it.
    pub fn repeated(scenario: Scenario, led_m: &[f64]) -> Result<Self, RunError> {
        let mut run = Self::new(scenario, UserDefinedParts::default())?;
        run.repeat(led_m)?;
        Ok(run)
    }

    /// A tick for each position; NaN for the operator's own.
    pub fn repeat(&mut self, led_m: &[f64]) -> Result<(), RunError> {
        for position_m in led_m {
            self.step(Some(*position_m).filter(|position_m| !position_m.is_nan()))?;
        }
        Ok(())
    }

    /// The desired position moves linearly to `desired_m`, or with `None` to the operator's position. Returns true if
    /// there are more ticks.
    pub fn step(&mut self, desired_m: Option<f64>) -> Result<bool, RunError> {
        if self.has_ended {
            return Ok(false);
        }
        let tick = self.ticks();
        self.led.store(desired_m.unwrap_or(f64::NAN).to_bits(), Ordering::Relaxed);
        let engine = &mut self.engine;
        let outcome = match engine.parts.tick(tick, self.desired_m, &mut engine.plants, &mut self.observers) {
            ControlFlow::Continue(next_m) => {
                self.desired_m = next_m;
                self.has_ended = tick + 1 >= engine.grid.ticks();
                Ok(())
            }
            ControlFlow::Break(outcome) => {
                self.has_ended = true;
                outcome
            }
        };
        if self.has_ended {
            checked_outcome(&self.scenario, &self.observers.0, outcome)?;
        }
        self.led_m.push(desired_m.unwrap_or(f64::NAN));
        Ok(!self.has_ended)
    }

    /// Continues with a changed scenario's parts from the next tick on: `sections` are those of the changed keys, of
    /// `scaling` (link without delay), `tissue` (spring and damper, or without layers), `estimator`, `detector` and
    /// `augmentation`. Estimator, detector and supervisor begin anew; metrics and summary describe the scenario at the
    /// beginning.
    ///
    /// # Errors
    /// [`RunError::Scenario`] for other sections, for user-defined parts in them, for a changed detector or
    /// augmentation during an event, and if the parts cannot be built; the run is then unchanged.
    pub fn change(&mut self, changed: &Scenario, sections: &[&str]) -> Result<(), RunError> {
        let next = changed.build_with(UserDefinedParts::default())?;
        let refuse = |message: &str, remedy: &str| Err(ScenarioError::new(message).remedy(remedy).into());
        let user_defined = self.observers.0.user_defined().to_vec();
        let is_user_defined = |roles: &[&str]| roles.iter().any(|role| user_defined.contains(role));
        let is_in_event = self.trace().mode.last().is_some_and(|mode| *mode != Mode::Teleoperation.code());
        for section in sections {
            let roles: &[&str] = match *section {
                "scaling" => &["architecture", "scheme"],
                "tissue" => &["tissue"],
                "estimator" => &["estimator"],
                "detector" => &["detector", "distance"],
                "augmentation" => &["motion law", "force law"],
                other => {
                    let message = format!("the keys of {other} cannot change during a simulation");
                    let remedy = "keys of scaling, tissue, estimator, detector and augmentation can";
                    return refuse(&message, remedy);
                }
            };
            if is_user_defined(roles) {
                let message = format!("the keys of {section} have no effect: its part is user-defined");
                return refuse(&message, "change the user-defined part itself");
            }
        }
        let changes = |section: &str| sections.contains(&section);
        if (changes("detector") || changes("augmentation")) && is_in_event {
            let message = "the keys of detector and augmentation cannot change during an event";
            return refuse(message, "wait until the mode is teleoperation again");
        }
        let is_direct = |link: &BuiltInOr<_, _>| matches!(link, BuiltInOr::BuiltIn(_));
        if changes("scaling") && !(is_direct(&self.engine.parts.link) && is_direct(&next.parts.link)) {
            let message = "scaling cannot change during a simulation whose link has a delay, a passivity scheme or another controller";
            return refuse(message, "change it in the scenario, before the simulation");
        }
        let has_memory =
            |scenario: &Scenario| !TissueRange::of_parameters(scenario).is_some_and(|range| range.is_whole_tissue());
        if changes("tissue") && (has_memory(&self.scenario) || has_memory(changed)) {
            let message = "the tissue has layers or other memory, and cannot change during a simulation";
            return refuse(message, "use a spring and damper, or a user-defined tissue that changes itself");
        }
        let (parts, next) = (&mut self.engine.parts, next.parts);
        if changes("scaling") {
            parts.link = next.link;
        }
        if changes("tissue") {
            parts.tissue = next.tissue;
        }
        if changes("estimator") {
            (parts.chain.contact_m, parts.chain.estimator) = (next.chain.contact_m, next.chain.estimator);
        }
        if changes("detector") {
            parts.chain.detector = next.chain.detector;
        }
        if (changes("detector") || changes("augmentation")) && !is_user_defined(&["motion law", "force law"]) {
            parts.supervisor = next.supervisor;
        }
        Ok(())
    }

    pub fn scenario(&self) -> &Scenario {
        &self.scenario
    }

    pub fn ticks(&self) -> u64 {
        self.led_m.len() as u64
    }

    /// The position that a person gave at each tick; NaN at ticks without one.
    pub fn led_m(&self) -> &[f64] {
        &self.led_m
    }

    pub fn has_ended(&self) -> bool {
        self.has_ended
    }

    pub fn trace(&self) -> &Trace {
        &self.observers.1.1
    }

    pub fn metrics(&self) -> Metrics {
        self.observers.1.0.metrics(0)
    }

    pub fn conclude(self) -> Run {
        let (checked, (metrics, trace)) = self.observers;
        let metrics = with_link(&self.scenario, metrics.metrics(0), self.engine.parts.link_report(0));
        Run::of_user_defined_parts(self.scenario, checked.user_defined().to_vec(), metrics, trace)
    }
}

impl std::fmt::Debug for SteppedRun {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("SteppedRun").field("scenario", &self.scenario.name).field("tick", &self.ticks()).finish()
    }
}

/// Holds the given position's bits; NaN selects the operator's.
struct Led {
    operator: BuiltInOr<HumanOperator<f64>, dyn Operator<f64> + Send>,
    led: Arc<AtomicU64>,
}

impl Operator<f64> for Led {
    fn desired_position_m(&mut self, tick: u64, felt_n: f64) -> f64 {
        let operator_m = self.operator.desired_position_m(tick, felt_n);
        let led_m = f64::from_bits(self.led.load(Ordering::Relaxed));
        if led_m.is_nan() { operator_m } else { led_m }
    }

    fn intended_position_m(&self, desired_m: f64) -> f64 {
        self.operator.intended_position_m(desired_m)
    }

    fn master(&mut self, position_m: f64) {
        self.operator.master(position_m);
    }

    fn cue(&mut self, is_on: bool) {
        self.operator.cue(is_on);
    }

    fn notices(&self) -> bool {
        self.operator.notices()
    }
}
