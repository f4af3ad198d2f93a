use std::borrow::Cow;
use std::collections::HashMap;
use std::path::Path;

use thiserror::Error;

use trocar_core::error::InvalidValue;
use trocar_core::rig::{HapticController, Sample};
use trocar_core::safety::SafetyState;
use trocar_core::time::whole_ticks;
use trocar_engine::engine::{ColumnValues, UserDefinedParts};
use trocar_engine::tissue::{AnyTissue, Tissue as _};
use trocar_scenario::{Scenario, ScenarioError, Source};
use trocar_studies::fmu::{
    Causality, FIRST_COLUMN, IS_LED, Model, POSITION, STOP, Scalar, Type, Variable, rig_outputs, token,
};
use trocar_studies::run::{RunError, SteppedRun};

#[derive(Debug, Error)]
pub enum InstanceError {
    #[error("{folder} contains no rig.toml, simulation.toml or tissue.toml: unpack the whole unit, with its resources")]
    NoScenario { folder: String },
    #[error(
        "the description and the scenario in resources belong to different units: export the unit again with trocar \
         export fmu"
    )]
    Foreign,
    #[error(transparent)]
    Scenario(#[from] ScenarioError),
    #[error(transparent)]
    Setting(#[from] InvalidValue),
    #[error(transparent)]
    Run(#[from] RunError),
    #[error("there is no {kind} variable with the reference {reference}")]
    NoVariable { kind: &'static str, reference: u32 },
    #[error("{name} cannot be set {when}")]
    NotSettable { name: Cow<'static, str>, when: &'static str },
    #[error("{name} is {value}, must be from 0 to {last}")]
    NoWord { name: Cow<'static, str>, value: i64, last: usize },
    #[error(
        "a step of {step_s} s is not a whole number of ticks of {tick_s} s: choose a multiple of simulation.tick_s"
    )]
    Step { step_s: f64, tick_s: f64 },
    #[error("the step begins at {time_s} s, and the last one has ended at {expected_s} s: continue from there")]
    Time {
        /// The given communication point.
        time_s: f64,
        expected_s: f64,
    },
    #[error("a step needs an initialised unit")]
    NotInitialised,
    #[error("person.position_m is {position_m}, must be a finite number")]
    Position { position_m: f64 },
    #[error("the scenario ends after {ticks} ticks: set a longer simulation.duration_s")]
    Ended { ticks: u64 },
}

/// Largest difference of a communication point from the expected one, in ticks.
const TIME_TOLERANCE: f64 = 0.01;

#[derive(Debug)]
pub(super) enum Running {
    Nothing,
    Rig(Box<HapticController>),
    Simulation(Box<SteppedRun>),
    Tissue(Box<AnyTissue<f64>>),
}

#[derive(Debug)]
pub struct Instance {
    model: Model,
    source: Source,
    variables: Vec<Variable>,
    pub(super) values: Vec<Scalar>,
    /// Index by reference.
    places: HashMap<u32, usize>,
    pub(super) running: Running,
    /// `None` before the initialisation.
    pub(super) clock: Option<Clock>,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Clock {
    tick_s: f64,
    origin_s: Option<f64>,
    ticks: u64,
}

impl Clock {
    fn time_s(&self) -> Option<f64> {
        self.origin_s.map(|origin_s| origin_s + self.ticks as f64 * self.tick_s)
    }

    /// The first step may have any communication point.
    fn check(&mut self, time_s: f64) -> Result<(), InstanceError> {
        let expected_s = self.time_s().unwrap_or(time_s);
        // An importing program may accumulate its time, so the tolerance is a part of a tick.
        let is_expected = (time_s - expected_s).abs() <= TIME_TOLERANCE * self.tick_s;
        if !is_expected {
            return Err(InstanceError::Time { time_s, expected_s });
        }
        self.origin_s.get_or_insert(time_s);
        Ok(())
    }
}

impl Instance {
    pub fn load(resources: &Path, given_token: &str) -> Result<Self, InstanceError> {
        let has = |model: &Model| resources.join(model.file()).is_file();
        let no_scenario = || InstanceError::NoScenario { folder: resources.display().to_string() };
        let model = Model::ALL.into_iter().find(has).ok_or_else(no_scenario)?;
        let source = Source::Disk(resources.join(model.file()));
        if token(model, &source.read()?) != given_token {
            return Err(InstanceError::Foreign);
        }
        let variables = model.variables(&Scenario::load(&source, &[])?);
        let values = variables.iter().map(|variable| variable.start).collect();
        let places = variables.iter().enumerate().map(|(place, variable)| (variable.reference, place)).collect();
        Ok(Self { model, source, variables, values, places, running: Running::Nothing, clock: None })
    }

    fn place(&self, reference: u32, kind: &'static str) -> Result<usize, InstanceError> {
        self.places.get(&reference).copied().ok_or(InstanceError::NoVariable { kind, reference })
    }

    pub fn get(&self, reference: u32, kind: &'static str) -> Result<Scalar, InstanceError> {
        Ok(self.values[self.place(reference, kind)?])
    }

    pub fn set(&mut self, reference: u32, kind: &'static str, value: Scalar) -> Result<(), InstanceError> {
        let place = self.place(reference, kind)?;
        let Variable { ref name, causality, kind: of_variable, .. } = self.variables[place];
        let fits = matches!(
            (of_variable, value),
            (Type::Real(_), Scalar::Real(_))
                | (Type::Integer(_) | Type::Choice(_), Scalar::Integer(_))
                | (Type::Boolean, Scalar::Boolean(_))
        );
        if !fits {
            return Err(InstanceError::NoVariable { kind, reference });
        }
        let refused = match causality {
            Causality::Input => None,
            Causality::Output => Some("as it is an output"),
            Causality::Parameter if matches!(self.running, Running::Nothing) => None,
            Causality::Parameter => Some("after the initialisation"),
        };
        if let Some(when) = refused {
            return Err(InstanceError::NotSettable { name: name.clone(), when });
        }
        if let (Type::Choice(words), Scalar::Integer(value)) = (of_variable, value)
            && !usize::try_from(value).is_ok_and(|place| place < words.len())
        {
            return Err(InstanceError::NoWord { name: name.clone(), value, last: words.len() - 1 });
        }
        self.values[place] = value;
        Ok(())
    }

    /// Parameters that differ from their start, as settings of a scenario; those that only a rig has, as numbers.
    fn changes(&self) -> (Vec<String>, Vec<(&'static str, f64)>) {
        let (mut settings, mut of_rig) = (vec![], vec![]);
        for (variable, value) in self.variables.iter().zip(&self.values) {
            if variable.causality != Causality::Parameter || variable.start == *value {
                continue;
            }
            let name = &variable.name;
            match (variable.kind, *value, name) {
                (Type::Real(_), Scalar::Real(value), Cow::Borrowed(name)) if name.starts_with("rig.") => {
                    of_rig.push((*name, value));
                }
                (Type::Choice(words), Scalar::Integer(place), _) => {
                    let word = usize::try_from(place).ok().and_then(|place| words.get(place));
                    settings.extend(word.map(|word| format!("{name}={word:?}")));
                }
                (_, Scalar::Real(value), _) => settings.push(format!("{name}={value:?}")),
                (_, Scalar::Integer(value), _) => settings.push(format!("{name}={value}")),
                (_, Scalar::Boolean(value), _) => settings.push(format!("{name}={value}")),
            }
        }
        (settings, of_rig)
    }

    pub fn initialise(&mut self) -> Result<(), InstanceError> {
        let (settings, of_rig) = self.changes();
        let scenario = Scenario::load(&self.source, &settings)?;
        let clock = Clock { tick_s: scenario.grid.tick_s(), origin_s: None, ticks: 0 };
        self.running = match self.model {
            Model::Rig => {
                let controller = HapticController::new(&scenario.rig_settings_with(&of_rig)?)?;
                Running::Rig(Box::new(controller))
            }
            Model::Simulation => Running::Simulation(Box::new(SteppedRun::new(scenario, UserDefinedParts::default())?)),
            Model::Tissue => Running::Tissue(Box::new(scenario.tissue_part()?)),
        };
        self.clock = Some(clock);
        Ok(())
    }

    /// With the present inputs.
    pub fn step(&mut self, time_s: f64, step_s: f64) -> Result<(), InstanceError> {
        let clock = self.clock.as_mut().ok_or(InstanceError::NotInitialised)?;
        let tick_s = clock.tick_s;
        let ticks = whole_ticks(step_s, tick_s).filter(|ticks| *ticks > 0);
        let ticks = ticks.ok_or(InstanceError::Step { step_s, tick_s })?;
        clock.check(time_s)?;
        let first = clock.ticks;
        for tick in first..first + ticks {
            self.tick(tick)?;
            if let Some(clock) = &mut self.clock {
                clock.ticks = tick + 1;
            }
        }
        Ok(())
    }

    pub fn time_s(&self) -> Option<f64> {
        self.clock.as_ref()?.time_s()
    }

    pub fn has_ended(&self) -> bool {
        if let Running::Simulation(run) = &self.running { run.has_ended() } else { false }
    }

    fn tick(&mut self, tick: u64) -> Result<(), InstanceError> {
        let first_output =
            self.variables.iter().position(|variable| variable.causality == Causality::Output).unwrap_or(0);
        let (inputs, rest) = self.values.split_at_mut(first_output);
        let number = |place: usize| if let Scalar::Real(value) = inputs[place] { value } else { f64::NAN };
        match &mut self.running {
            Running::Nothing => Err(InstanceError::NotInitialised),
            Running::Rig(controller) => {
                match (inputs[STOP] == Scalar::Boolean(true), controller.safety_state()) {
                    (true, _) => controller.stop(),
                    (false, SafetyState::Disabled) => controller.enable(),
                    (false, _) => {}
                }
                let command = controller.step(&Sample {
                    master_position_m: number(0),
                    slave_position_m: number(1),
                    slave_velocity_m_per_s: number(2),
                    force_n: number(3),
                });
                rest.iter_mut().zip(rig_outputs(&command)).for_each(|(value, output)| *value = output);
                Ok(())
            }
            Running::Tissue(tissue) => {
                let reaction = tissue.react(tick, number(0), number(1));
                let outputs = [
                    Scalar::Real(reaction.force_n),
                    Scalar::Real(tissue.shaft_force_n()),
                    Scalar::Boolean(reaction.ruptured),
                ];
                rest.iter_mut().zip(outputs).for_each(|(value, output)| *value = output);
                Ok(())
            }
            Running::Simulation(run) => {
                if run.has_ended() {
                    return Err(InstanceError::Ended { ticks: run.ticks() });
                }
                let is_led = inputs[IS_LED] == Scalar::Boolean(true);
                let led_m = is_led.then(|| number(POSITION));
                if let Some(position_m) = led_m.filter(|position_m| !position_m.is_finite()) {
                    return Err(InstanceError::Position { position_m });
                }
                run.step(led_m)?;
                let columns = run.trace().columns();
                for (value, column) in rest.iter_mut().zip(&columns[FIRST_COLUMN..]) {
                    let last = match column {
                        ColumnValues::Numbers(numbers) => numbers.last().map(|number| Scalar::Real(*number)),
                        ColumnValues::Codes(codes) => codes.last().map(|code| Scalar::Integer(i64::from(*code))),
                    };
                    *value = last.unwrap_or(*value);
                }
                Ok(())
            }
        }
    }

    pub fn reset(&mut self) {
        self.running = Running::Nothing;
        self.clock = None;
        self.values = self.variables.iter().map(|variable| variable.start).collect();
    }
}
