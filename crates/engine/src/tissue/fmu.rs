use std::path::Path;
use std::sync::Arc;

use trocar_fmu_import::{Causality, Fmu as Unit, Instance, Variable};

pub use trocar_fmu_import::FmuError;

use super::model::NEEDS_FILE;
use super::{FmuSettings, Model, Reaction, Tissue, TissueFailure, UnfitUnit, UnitProblem};
use trocar_core::error::InvalidValue;
use trocar_core::lane::{Gather, LANES, Lane};
use trocar_core::time::whole_ticks;

/// Names in exported units, used if their keys have no value.
const VELOCITY: &str = "needle.velocity_m_per_s";
const SHAFT_FORCE: &str = "reaction.shaft_force_n";
const RUPTURED: &str = "reaction.ruptured";

/// Exponents of kg, m, s, A, K, mol, cd and rad.
const METRE: (&str, [i32; 8]) = ("m", [0, 1, 0, 0, 0, 0, 0, 0]);
const METRE_PER_SECOND: (&str, [i32; 8]) = ("m/s", [0, 1, -1, 0, 0, 0, 0, 0]);
const NEWTON: (&str, [i32; 8]) = ("N", [1, 1, -2, 0, 0, 0, 0, 0]);

#[derive(Debug, Clone)]
pub struct UnitTissue {
    unit: Arc<Unit>,
    tick_s: f64,
    step_s: f64,
    step_ticks: u64,
    inputs: Vec<u32>,
    outputs: Vec<u32>,
    ruptured: Option<Variable>,
    parameters: Vec<(Variable, f64)>,
}

impl UnitTissue {
    /// Executes nothing of the unit.
    pub fn open(path: &Path, settings: &FmuSettings, tick_s: f64) -> Result<Self, UnfitUnit> {
        const KEYS: [&str; 7] = {
            let mut paths = [""; 7];
            let mut index = 0;
            while index < paths.len() {
                paths[index] = FmuSettings::KEYS[index].path;
                index += 1;
            }
            paths
        };
        let [file, step, position, velocity, force, ruptured, parameters] = KEYS;
        let of_unit = |key| move |error| UnfitUnit { key, problem: UnitProblem::Unit(error) };
        let unit = Unit::open_shared(path).map_err(of_unit(file))?;
        let step_s = settings.step_s.unwrap_or(tick_s);
        let step_ticks = whole_ticks(step_s, tick_s).filter(|ticks| *ticks > 0).ok_or_else(|| {
            let problem = format!("is {step_s:?}, must be a whole number of ticks of {tick_s:?} s");
            UnfitUnit { key: step, problem: UnitProblem::Setting(problem) }
        })?;
        let description = unit.description();
        if let Some(internal_s) = description.internal_step_s
            && !is_multiple(step_s, internal_s)
        {
            return Err(of_unit(step)(FmuError::Step { step_s, internal_s }));
        }
        let number = |key, name: &str, role, quantity| description.number(name, role, quantity).map_err(of_unit(key));
        let has = |name: &&str| description.variables.iter().any(|variable| variable.name == **name);
        let given_or = |given: &Option<String>, default: &'static str| match given {
            Some(name) => Some(name.clone()),
            None => Some(default).filter(has).map(str::to_owned),
        };
        let mut inputs = vec![number(position, &settings.position, Causality::Input, METRE)?];
        if let Some(name) = given_or(&settings.velocity, VELOCITY) {
            inputs.push(number(velocity, &name, Causality::Input, METRE_PER_SECOND)?);
        }
        let mut outputs = vec![number(force, &settings.force, Causality::Output, NEWTON)?];
        if has(&SHAFT_FORCE) {
            outputs.push(number(file, SHAFT_FORCE, Causality::Output, NEWTON)?);
        }
        let ruptured = given_or(&settings.ruptured, RUPTURED)
            .map(|name| readable(&unit, &name).map_err(of_unit(ruptured)))
            .transpose()?;
        let given = settings.parameters.as_deref().unwrap_or_default();
        let parameters = given
            .split(';')
            .filter(|item| !item.trim().is_empty())
            .map(|item| parameter(&unit, item).map_err(|problem| UnfitUnit { key: parameters, problem }))
            .collect::<Result<_, _>>()?;
        Ok(Self { unit, tick_s, step_s, step_ticks, inputs, outputs, ruptured, parameters })
    }

    pub fn load(&self) -> Result<(), FmuError> {
        self.unit.load()
    }

    #[must_use]
    pub fn path(&self) -> &Path {
        self.unit.path()
    }

    #[must_use]
    pub fn sha256(&self) -> [u8; 32] {
        self.unit.sha256()
    }

    fn failure(&self, time_s: f64, what: &str) -> TissueFailure {
        TissueFailure::new(format!("{}: at {time_s} s, {what}", self.unit.path().display()))
    }
}

impl PartialEq for UnitTissue {
    fn eq(&self, other: &Self) -> bool {
        self.sha256() == other.sha256()
            && (self.tick_s, self.step_s) == (other.tick_s, other.step_s)
            && (&self.inputs, &self.outputs, &self.ruptured) == (&other.inputs, &other.outputs, &other.ruptured)
            && self.parameters == other.parameters
    }
}

fn is_multiple(step_s: f64, of_s: f64) -> bool {
    let count = step_s / of_s;
    count > 0.5 && (count - count.round()).abs() <= 1e-6 * count
}

fn readable(unit: &Unit, name: &str) -> Result<Variable, FmuError> {
    let variable = unit.description().variable(name, Causality::Output)?;
    let refuse = |problem: &str| Err(FmuError::Variable { name: name.into(), problem: problem.into() });
    match (variable.causality, variable.kind) {
        (Causality::Output, Some(_)) => Ok(variable.clone()),
        (Causality::Output, None) => refuse("is not a truth value or a single number"),
        _ => refuse("is not an output"),
    }
}

fn parameter(unit: &Unit, written: &str) -> Result<(Variable, f64), UnitProblem> {
    let wrong = || UnitProblem::Setting(format!("has {:?}, must be name = number; name = number", written.trim()));
    let (name, value) = written.rsplit_once('=').ok_or_else(wrong)?;
    let (name, value) = (name.trim(), value.trim().parse::<f64>().map_err(|_| wrong())?);
    let variable = unit.description().variable(name, Causality::Parameter).map_err(UnitProblem::Unit)?;
    let refuse = |problem: String| Err(UnitProblem::Unit(FmuError::Variable { name: name.into(), problem }));
    match variable.kind {
        _ if !variable.is_settable => refuse("cannot be set".into()),
        Some(kind) if kind.takes(value) => Ok((variable.clone(), value)),
        Some(kind) => refuse(format!("has the type {kind:?}, and cannot be {value}")),
        None => refuse("is not a single number or truth value".into()),
    }
}

/// The outputs after a step act from its first tick on.
#[derive(Debug)]
pub struct Fmu<L: Lane> {
    tissue: Arc<UnitTissue>,
    instances: Vec<RunningUnit>,
    force_n: L,
    shaft_n: L,
    failure: Option<TissueFailure>,
}

#[derive(Debug)]
struct RunningUnit {
    instance: Instance,
    was_ruptured: bool,
}

struct Step {
    force_n: f64,
    shaft_n: f64,
    ruptures: bool,
}

impl<L: Lane> Fmu<L> {
    #[must_use]
    pub fn new(tissue: Arc<UnitTissue>) -> Self {
        Self { tissue, instances: vec![], force_n: L::zero(), shaft_n: L::zero(), failure: None }
    }

    fn step(&mut self, lane: usize, tick: u64, inputs: [f64; 2]) -> Result<Step, TissueFailure> {
        let tissue = &*self.tissue;
        let time_s = tick as f64 * tissue.tick_s;
        let failed = |error: FmuError| tissue.failure(time_s, &format!("the unit {}", sentence(&error)));
        let inputs = &inputs[..tissue.inputs.len()];
        if self.instances.len() == lane {
            let mut instance = Instance::new(&tissue.unit, &tissue.parameters).map_err(failed)?;
            instance.set_numbers(&tissue.inputs, inputs).map_err(failed)?;
            instance.start().map_err(failed)?;
            self.instances.push(RunningUnit { instance, was_ruptured: false });
        }
        let RunningUnit { instance, was_ruptured } = &mut self.instances[lane];
        instance.set_numbers(&tissue.inputs, inputs).map_err(failed)?;
        instance.step(time_s, tissue.step_s).map_err(failed)?;
        let mut outputs = [0.0; 2];
        instance.get_numbers(&tissue.outputs, &mut outputs[..tissue.outputs.len()]).map_err(failed)?;
        let is_ruptured = match &tissue.ruptured {
            Some(variable) => instance.is_set(variable).map_err(failed)?,
            None => false,
        };
        let ruptures = is_ruptured && !*was_ruptured;
        *was_ruptured = is_ruptured;
        let [force_n, shaft_n] = outputs;
        if !(force_n.is_finite() && shaft_n.is_finite()) {
            let given = if force_n.is_finite() { shaft_n } else { force_n };
            return Err(tissue.failure(time_s, &format!("the unit gives a force of {given} N")));
        }
        Ok(Step { force_n, shaft_n, ruptures })
    }
}

fn sentence(error: &FmuError) -> String {
    match error {
        FmuError::Call { .. } | FmuError::Variable { .. } => format!("stopped: {error}"),
        other => other.to_string(),
    }
}

impl<L: Lane> Tissue<L> for Fmu<L> {
    fn react(&mut self, tick: u64, position_m: L, velocity_m_per_s: L) -> Reaction<L> {
        let mut ruptured = L::zero();
        if tick.is_multiple_of(self.tissue.step_ticks) && self.failure.is_none() {
            for lane in 0..L::WIDTH {
                let inputs = [position_m.lane(lane), velocity_m_per_s.lane(lane)];
                let step = if inputs.iter().all(|input| input.is_finite()) {
                    self.step(lane, tick, inputs)
                } else {
                    Ok(Step { force_n: f64::NAN, shaft_n: 0.0, ruptures: false })
                };
                match step {
                    Ok(Step { force_n, shaft_n, ruptures }) => {
                        self.force_n.set_lane(lane, force_n);
                        self.shaft_n.set_lane(lane, shaft_n);
                        ruptured.set_lane(lane, f64::from(u8::from(ruptures)));
                    }
                    Err(failure) => {
                        self.force_n = L::splat(f64::NAN);
                        self.failure = Some(failure);
                        break;
                    }
                }
            }
        }
        Reaction { force_n: self.force_n, ruptured: ruptured.gt(L::splat(0.5)) }
    }

    fn shaft_force_n(&self) -> L {
        self.shaft_n
    }

    fn failure(&self) -> Option<&TissueFailure> {
        self.failure.as_ref()
    }
}

/// A running unit cannot be copied.
impl<L: Lane> Clone for Fmu<L> {
    fn clone(&self) -> Self {
        let mut copy = Self::new(Arc::clone(&self.tissue));
        if !self.instances.is_empty() {
            copy.failure = Some(self.tissue.failure(0.0, "the unit runs, and its state cannot be copied"));
            copy.force_n = L::splat(f64::NAN);
        }
        copy
    }
}

impl<L: Lane> Model for Fmu<L> {
    type Settings = FmuSettings;

    fn build(_settings: &FmuSettings, _tick_s: f64, _start_m: f64) -> Result<Self, InvalidValue> {
        Err(NEEDS_FILE)
    }

    fn check(_settings: &FmuSettings, _tick_s: f64, _start_m: f64) -> Result<(), InvalidValue> {
        Ok(())
    }
}

impl Gather for Fmu<f64> {
    type Of<L: Lane> = Fmu<L>;

    fn gather<L: Lane>(_all: [&Self; LANES]) -> Option<Fmu<L>> {
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_step_is_a_multiple_of_the_internal_step_within_a_millionth_of_it() {
        assert!([(1e-3, 1e-3), (3e-3, 1e-3), (1.0, 1e-4), (0.3, 0.1)].iter().all(|&(step, of)| is_multiple(step, of)));
        assert!(
            [(1.5e-3, 1e-3), (1e-3, 2e-3), (0.5, 1.0), (1e-3, 1.0), (1e-7, 1.0)]
                .iter()
                .all(|&(step, of)| !is_multiple(step, of))
        );
        assert_eq!((is_multiple(1.0 + 0.9e-6, 1.0), is_multiple(1.0 + 1.1e-6, 1.0)), (true, false));
        assert_eq!((is_multiple(4.0 + 3.9e-6, 1.0), is_multiple(4.0 + 4.1e-6, 1.0)), (true, false));
    }

    #[test]
    fn an_error_during_a_run_says_that_the_unit_stopped() {
        let of_variable = FmuError::Variable { name: "x".into(), problem: "cannot be set".into() };
        assert_eq!(sentence(&of_variable), format!("stopped: {of_variable}"));
        let of_step = FmuError::Step { step_s: 1e-3, internal_s: 2e-3 };
        assert_eq!(sentence(&of_step), of_step.to_string());
    }
}
