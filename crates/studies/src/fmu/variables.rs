use std::borrow::Cow;

use trocar_core::rig;
use trocar_engine::engine::TRACE_COLUMNS;
use trocar_scenario::{KEYS, Key, KeyAt, Kind, Scenario, Value, unit_of};

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Model {
    /// Samples in, commands and alarm out.
    Rig,
    /// The person's position in; positions, forces and mode out.
    Simulation,
    /// Position and velocity of the needle in, force out.
    Tissue,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Causality {
    Parameter,
    Input,
    Output,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Type {
    /// Minimum and maximum.
    Real(Option<(f64, f64)>),
    /// Minimum.
    Integer(u64),
    Boolean,
    /// The index of a word in a list.
    Choice(&'static [&'static str]),
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Scalar {
    Real(f64),
    Integer(i64),
    Boolean(bool),
}

#[derive(Debug, Clone, PartialEq)]
pub struct Variable {
    /// Key of the setting for a parameter.
    pub name: Cow<'static, str>,
    pub reference: u32,
    pub causality: Causality,
    pub kind: Type,
    pub unit: Option<String>,
    pub meaning: &'static str,
    pub start: Scalar,
}

const INPUTS: u32 = 1;
const OUTPUTS: u32 = 100;
const PARAMETERS: u32 = 1000;

const DETECTION: &[&str] = &["armed", "settling", "blind"];
const STATES: &[&str] = &["disabled", "aligning", "active", "fault"];
const FAULTS: &[&str] = &["none", "bad-samples", "stuck-force", "force-sign", "velocity"];

const MODES: &[&str] = &["teleoperation", "augmented", "reengaging"];

type Declared = (&'static str, Type, &'static str);

const NUMBER: Type = Type::Real(None);

const RIG_INPUTS: [Declared; 5] = [
    ("sample.master_position_m", NUMBER, "Position of the master."),
    ("sample.slave_position_m", NUMBER, "Position of the slave, growing into the tissue."),
    (
        "sample.slave_velocity_m_per_s",
        NUMBER,
        "Velocity of the slave; not read if sensor.position_resolution_m is above 0.",
    ),
    ("sample.force_n", NUMBER, "Force on the needle, positive when it resists insertion."),
    ("sample.stop", Type::Boolean, "Stops: the force decays and the reference holds; false again ends the stop."),
];

/// Index among the inputs of a rig.
pub const STOP: usize = 4;

const RIG_OUTPUTS: [Declared; 19] = [
    ("command.slave_reference_m", NUMBER, "Reference of the slave's position controller."),
    ("command.master_force_n", NUMBER, "Feedback force for the master's force controller."),
    ("command.allowed_force_step_n", NUMBER, "Largest change of the feedback force that the active law allows."),
    ("command.stiffness_n_per_m", NUMBER, "Estimated stiffness of the tissue."),
    ("command.damping_n_s_per_m", NUMBER, "Estimated damping of the tissue."),
    ("command.predicted_force_n", NUMBER, "Predicted force; 0 without a prediction."),
    ("command.residual_n", NUMBER, "Measured minus predicted force."),
    ("command.distance", NUMBER, "Distance from the hypothesis of no rupture."),
    ("command.decision", NUMBER, "Decision function g: an alarm is raised above detector.threshold."),
    ("command.slave_velocity_m_per_s", NUMBER, "Velocity of the slave as used by the estimator."),
    ("command.mode", Type::Choice(MODES), "Mode of the supervisor."),
    ("command.alarm", Type::Boolean, "True if the detector raises an alarm."),
    ("command.alarm_taken", Type::Boolean, "True if the supervisor acts on the alarm."),
    (
        "command.faults",
        Type::Integer(0),
        "Faults of the sample, a sum: 1 master position, 2 slave position, 4 slave velocity, 8 force.",
    ),
    ("command.faulty_samples", Type::Integer(0), "Number of consecutive bad samples, including this one."),
    ("command.detection", Type::Choice(DETECTION), "State of the detection; only an armed detector raises an alarm."),
    ("command.state", Type::Choice(STATES), "State of the commands."),
    ("command.fault", Type::Choice(FAULTS), "Cause of the last fault."),
    (
        "command.limited",
        Type::Integer(0),
        "Limits that acted, a sum: 1 force, 2 rate of the force, 4 speed of the reference, 8 its distance from the slave.",
    ),
];

/// Ordered like a rig's variables.
pub fn rig_outputs(command: &rig::Command) -> [Scalar; 19] {
    [
        Scalar::Real(command.slave_reference_m),
        Scalar::Real(command.master_force_n),
        Scalar::Real(command.allowed_force_step_n),
        Scalar::Real(command.stiffness_n_per_m),
        Scalar::Real(command.damping_n_s_per_m),
        Scalar::Real(command.predicted_force_n),
        Scalar::Real(command.residual_n),
        Scalar::Real(command.distance),
        Scalar::Real(command.decision),
        Scalar::Real(command.slave_velocity_m_per_s),
        Scalar::Integer(i64::from(command.mode.code())),
        Scalar::Boolean(command.alarm),
        Scalar::Boolean(command.alarm_taken),
        Scalar::Integer(i64::from(command.faults.bits())),
        Scalar::Integer(i64::from(command.faulty_samples)),
        Scalar::Integer(i64::from(command.detection.code())),
        Scalar::Integer(i64::from(command.state.code())),
        Scalar::Integer(command.fault.map_or(0, |cause| i64::from(cause.code()))),
        Scalar::Integer(i64::from(command.limited.bits())),
    ]
}

const SIMULATION_INPUTS: [Declared; 2] = [
    ("person.position_m", NUMBER, "Desired position of the master at the end of the step."),
    (
        "person.is_led",
        Type::Boolean,
        "True if person.position_m leads the person; otherwise the scenario's operator acts.",
    ),
];

/// Index of the person's position among the inputs of a simulation.
pub const POSITION: usize = 0;
/// Index of the flag that the position leads the simulation.
pub const IS_LED: usize = 1;

pub const FIRST_COLUMN: usize = 1;

fn simulation_outputs() -> Vec<Declared> {
    let kind = |name| if name == "mode" { Type::Choice(MODES) } else { NUMBER };
    TRACE_COLUMNS[FIRST_COLUMN..].iter().map(|column| (column.name, kind(column.name), column.meaning)).collect()
}

const TISSUE_INPUTS: [Declared; 2] = [
    ("needle.position_m", NUMBER, "Position of the needle, growing into the tissue."),
    ("needle.velocity_m_per_s", NUMBER, "Velocity of the needle."),
];

const TISSUE_OUTPUTS: [Declared; 3] = [
    ("reaction.force_n", NUMBER, "Force of the tissue on the needle, positive when it resists insertion."),
    ("reaction.shaft_force_n", NUMBER, "Part of that force that acts on the shaft, not on the tip."),
    ("reaction.ruptured", Type::Boolean, "True if a layer ruptures in this step."),
];

fn is_of_tissue(key: &Key) -> bool {
    key.path.starts_with("tissue.") || key.path == "simulation.tick_s"
}

impl Model {
    pub const ALL: [Self; 3] = [Self::Rig, Self::Simulation, Self::Tissue];

    /// The file name identifies the model.
    pub fn file(self) -> &'static str {
        match self {
            Self::Rig => "rig.toml",
            Self::Simulation => "simulation.toml",
            Self::Tissue => "tissue.toml",
        }
    }

    pub fn identifier(self) -> &'static str {
        match self {
            Self::Rig => "trocar_rig",
            Self::Simulation => "trocar_simulation",
            Self::Tissue => "trocar_tissue",
        }
    }

    pub fn variables(self, scenario: &Scenario) -> Vec<Variable> {
        let (inputs, outputs) = match self {
            Self::Rig => (RIG_INPUTS.to_vec(), RIG_OUTPUTS.to_vec()),
            Self::Simulation => (SIMULATION_INPUTS.to_vec(), simulation_outputs()),
            Self::Tissue => (TISSUE_INPUTS.to_vec(), TISSUE_OUTPUTS.to_vec()),
        };
        let declared = |causality, first, list: Vec<Declared>| {
            list.into_iter().zip(first..).map(move |((name, kind, meaning), reference)| Variable {
                name: Cow::Borrowed(name),
                reference,
                causality,
                kind,
                unit: unit_of(name),
                meaning,
                start: match kind {
                    Type::Real(_) => Scalar::Real(0.0),
                    Type::Integer(_) | Type::Choice(_) => Scalar::Integer(0),
                    // Without inputs, the unit is the exported scenario.
                    Type::Boolean => Scalar::Boolean(false),
                },
            })
        };
        let inputs = declared(Causality::Input, INPUTS, inputs);
        let outputs = declared(Causality::Output, OUTPUTS, outputs);
        inputs.chain(outputs).chain(self.parameters(scenario)).collect()
    }

    /// Only types of FMI 2.0: no lists, texts, files, missing values, or whole numbers beyond 32 bits.
    fn parameters(self, scenario: &Scenario) -> Vec<Variable> {
        let values: Vec<(KeyAt, Option<Value>)> = match self {
            Self::Rig => scenario.rig_values().map(|(key, value)| (key.into(), value)).collect(),
            Self::Simulation | Self::Tissue => {
                let values = scenario.values();
                let is_included = |key: &KeyAt| self == Self::Simulation || is_of_tissue(key);
                let acts = |key: &KeyAt| is_included(key) && values.is_acting(key);
                let keys = KEYS.iter().map(KeyAt::from).chain(values.layer_keys()).filter(acts);
                keys.map(|key| (key.clone(), values.get(&key.path).cloned())).collect()
            }
        };
        let parameter = |((key, value), reference): ((KeyAt, Option<Value>), u32)| {
            let (kind, start) = match (key.kind, value?) {
                (Kind::Number(range), Value::Number(value)) => {
                    let within = range.contains(value).then(|| (range.low().0, range.high()));
                    (Type::Real(within), Scalar::Real(value))
                }
                (Kind::Sign, Value::Number(value)) => (Type::Real(Some((-1.0, 1.0))), Scalar::Real(value)),
                (Kind::Whole(min), Value::Whole(value)) => {
                    (Type::Integer(min), Scalar::Integer(i64::from(i32::try_from(value).ok()?)))
                }
                (Kind::Flag, Value::Flag(value)) => (Type::Boolean, Scalar::Boolean(value)),
                (Kind::Choice(words), Value::Text(word)) => {
                    let place = words.iter().position(|known| **known == *word)?;
                    (Type::Choice(words), Scalar::Integer(place as i64))
                }
                _ => return None,
            };
            Some(Variable {
                name: key.path.clone(),
                reference,
                causality: Causality::Parameter,
                kind,
                unit: unit_of(&key.path),
                meaning: key.meaning,
                start,
            })
        };
        values.into_iter().zip(PARAMETERS..).filter_map(parameter).collect()
    }
}
