use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::Serialize;

use super::DesignStudy;
use super::tables::relation;
use crate::design::bootstrap::Estimate;
use crate::design::sensitivity::{Sensitivity, sensitivities};
use trocar_scenario::Value;

/// `design.json`: the designs on the front, the shipped strategies on the same patients, and the sensitivities.
#[derive(Debug, Serialize, JsonSchema)]
pub struct DesignResultFile<'a> {
    /// Version of trocar.
    trocar_version: &'static str,
    /// Name of the design.
    name: &'a str,
    /// SHA-256 of all inputs of the design.
    design_sha256: &'a str,
    /// Number of patients of the search.
    training_patients: u64,
    /// Number of other patients.
    validation_patients: u64,
    /// Number of noise seeds of each other patient and person.
    validation_seeds: u64,
    /// Number of generations.
    generations: u64,
    /// Number of runs of the search.
    runs: u64,
    /// Number of candidates that were evaluated on all patients of the search.
    complete: u64,
    /// Number of candidates that were stopped early.
    stopped: u64,
    /// Number of candidates whose values are not a valid scenario.
    refused: u64,
    /// Number of candidates on the front that are not shown because no certificate was found.
    uncertified: u64,
    /// The objectives by name.
    objectives: Vec<GoalFile<'a>>,
    /// The constraints on metrics.
    constraints: Vec<GoalFile<'a>>,
    /// True if every shown design is certified to decay; null if no certificate is required.
    is_certified: Option<bool>,
    /// The shown designs.
    designs: Vec<DesignFile<'a>>,
    /// The shipped strategies.
    shipped: Vec<ShippedFile<'a>>,
    /// For each free key, its influence on each objective.
    sensitivities: BTreeMap<&'a str, Vec<Sensitivity>>,
}

/// An objective or a constraint.
#[derive(Debug, Serialize, JsonSchema)]
struct GoalFile<'a> {
    /// Name.
    name: &'a str,
    /// Metric.
    metric: &'a str,
    /// SI unit of the metric.
    unit: &'static str,
    /// Aggregation over the runs.
    aggregate: String,
    /// `minimise` or `maximise`, or the limit with its side.
    goal: String,
}

/// A design.
#[derive(Debug, Serialize, JsonSchema)]
struct DesignFile<'a> {
    /// Name, which is that of its scenario file.
    name: &'a str,
    /// True if it is the knee of the front, which is `designed.toml`.
    is_knee: bool,
    /// The values of the free keys.
    settings: BTreeMap<&'a str, Setting>,
    /// Objectives, then constraints, in the search, with 95 % intervals; null if undefined.
    training: &'a [Option<Estimate>],
    /// Objectives, then constraints, on other patients, with 95 % intervals; null if undefined.
    validation: &'a [Option<Estimate>],
    /// Share of diverged runs on other patients.
    diverged: f64,
}

/// The value of a free key.
#[derive(Debug, Serialize, JsonSchema)]
#[serde(untagged)]
enum Setting {
    /// A number.
    Number(f64),
    /// A whole number.
    Whole(u64),
    /// True or false.
    Flag(bool),
    /// A word.
    Text(String),
    /// A list of numbers.
    Numbers(Vec<f64>),
}

impl From<Value> for Setting {
    fn from(value: Value) -> Self {
        match value {
            Value::Number(value) => Self::Number(value),
            Value::Whole(value) => Self::Whole(value),
            Value::Flag(value) => Self::Flag(value),
            Value::Text(value) => Self::Text(value),
            Value::Numbers(value) => Self::Numbers(value),
        }
    }
}

/// A shipped strategy.
#[derive(Debug, Serialize, JsonSchema)]
struct ShippedFile<'a> {
    /// Name.
    name: &'static str,
    /// Objectives, then constraints, on other patients, with 95 % intervals; null if undefined.
    validation: &'a [Option<Estimate>],
    /// Share of diverged runs.
    diverged: f64,
    /// True if it meets the constraints on metrics.
    is_feasible: bool,
    /// Knee minus strategy for each objective, with paired 95 % intervals; empty without a knee.
    knee_minus_strategy: &'a [Option<Estimate>],
    /// Number of objectives in which the knee is better with 95 % confidence.
    knee_better_in: Option<usize>,
    /// Number of objectives in which the knee is worse with 95 % confidence.
    knee_worse_in: Option<usize>,
}

impl<'a> DesignResultFile<'a> {
    pub(super) fn of(study: &'a DesignStudy<'a>) -> Self {
        let (problem, state, goals) = (study.problem, study.state, &study.problem.goals);
        let objectives = goals.objectives.iter().map(|objective| GoalFile {
            name: &objective.name,
            metric: &objective.quantity.name,
            unit: objective.quantity.unit.si(),
            aggregate: objective.aggregate.word(),
            goal: objective.direction.word().to_owned(),
        });
        let constraints = goals.constraints.iter().map(|constraint| GoalFile {
            name: &constraint.name,
            metric: &constraint.quantity.name,
            unit: constraint.quantity.unit.si(),
            aggregate: constraint.aggregate.word(),
            goal: match constraint.limit {
                crate::design::Limit::AtLeast(limit) => format!("at least {limit}"),
                crate::design::Limit::AtMost(limit) => format!("at most {limit}"),
            },
        });
        let designs = study.validation.designs.iter().map(|design| DesignFile {
            name: &design.name,
            is_knee: design.is_knee,
            settings: problem
                .free
                .iter()
                .zip(problem.values(&design.candidate.coordinates))
                .map(|(axis, value)| (axis.key.path.as_ref(), value.into()))
                .collect(),
            training: &design.training,
            validation: &design.validation,
            diverged: design.diverged,
        });
        let shipped = study.validation.shipped.iter().map(|shipped| {
            let relation = relation(study, shipped);
            ShippedFile {
                name: shipped.name,
                validation: &shipped.validation,
                diverged: shipped.diverged,
                is_feasible: shipped.is_feasible,
                knee_minus_strategy: &shipped.differences,
                knee_better_in: relation.map(|(better, _)| better),
                knee_worse_in: relation.map(|(_, worse)| worse),
            }
        });
        let keys = problem.free.iter().map(|axis| axis.key.path.as_ref());
        Self {
            trocar_version: env!("CARGO_PKG_VERSION"),
            name: &problem.name,
            design_sha256: &state.design_sha256,
            training_patients: study.patients as u64,
            validation_patients: study.fresh.population().patients() as u64,
            validation_seeds: problem.validation.seeds,
            generations: state.generations,
            runs: state.runs,
            complete: state.archive.len() as u64,
            stopped: state.stopped,
            refused: state.refused,
            uncertified: study.front.uncertified.len() as u64,
            objectives: objectives.collect(),
            constraints: constraints.collect(),
            is_certified: goals.certified.as_ref().map(|_| !study.validation.designs.is_empty()),
            designs: designs.collect(),
            shipped: shipped.collect(),
            sensitivities: keys.zip(sensitivities(problem, &state.archive)).collect(),
        }
    }
}
