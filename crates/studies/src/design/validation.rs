//! Judges the designs on other patients with other noise, beside the shipped strategies.

use std::sync::atomic::{AtomicBool, Ordering};

use super::bootstrap::{Estimate, Resamples, difference, estimate};
use super::evaluate::{Ended, Evaluation, Evaluator};
use super::population::{Population, Use};
use super::problem::Problem;
use super::search::{State, Stopped, Training, reference_population, ruptures_without_augmentation};
use crate::compare::STRATEGIES;
use crate::run::RunError;
use trocar_base::parallel::map;
use trocar_scenario::ScenarioError;

/// Separates the random numbers of the resamples from others with the same seed.
const RESAMPLING: u64 = 0x626f_6f74;

/// The other patients, for designs and for the shipped strategies.
#[derive(Debug)]
pub struct Fresh {
    pub(super) population: Population,
    without: Vec<u64>,
    references: Vec<Reference>,
    /// The strategies that cannot be combined with the scenario, each with the reason.
    pub(super) left_out: Vec<(&'static str, String)>,
}

#[derive(Debug)]
struct Reference {
    name: &'static str,
    population: Population,
}

impl Fresh {
    /// Draws the patients.
    ///
    /// # Errors
    /// [`RunError`].
    pub fn of(problem: &Problem) -> Result<Self, RunError> {
        let population = Population::of(problem, Use::Validation, &problem.free, &[])?;
        let without = ruptures_without_augmentation(problem, Use::Validation)?;
        let (mut references, mut left_out) = (vec![], vec![]);
        for strategy in &STRATEGIES {
            match reference_population(problem, Use::Validation, strategy.settings) {
                Ok(population) => references.push(Reference { name: strategy.name, population }),
                Err(ScenarioError { message, .. }) => left_out.push((strategy.name, message)),
            }
        }
        Ok(Self { population, without, references, left_out })
    }

    /// The population.
    #[must_use]
    pub fn population(&self) -> &Population {
        &self.population
    }

    /// Number of runs of a validation with so many designs.
    #[must_use]
    pub fn runs(&self, designs: usize) -> usize {
        (designs + self.references.len()) * self.population.runs()
    }
}

/// Values of the quantities with their intervals; `None` if undefined.
pub type Estimates = Vec<Option<Estimate>>;

/// A design on the front.
#[derive(Debug, Clone, PartialEq)]
pub struct Designed {
    /// Its name: its number on the front.
    pub name: String,
    /// The candidate, as evaluated in the search.
    pub candidate: Evaluation,
    /// The values in the search, with intervals over its patients.
    pub training: Estimates,
    /// The values on other patients.
    pub validation: Estimates,
    /// Share of diverged runs on other patients.
    pub diverged: f64,
    /// True if it is the knee of the front.
    pub is_knee: bool,
}

/// A shipped strategy on the same other patients.
#[derive(Debug, Clone, PartialEq)]
pub struct Shipped {
    /// Its name.
    pub name: &'static str,
    /// The values.
    pub validation: Estimates,
    /// Share of diverged runs.
    pub diverged: f64,
    /// True if no constraint on a quantity is violated.
    pub is_feasible: bool,
    /// The value of the knee minus that of the strategy, for each objective, over paired resamples.
    pub differences: Estimates,
}

/// The designs and the shipped strategies on other patients.
#[derive(Debug, Clone, PartialEq)]
pub struct Validation {
    /// The designs, in the order of the first objective.
    pub designs: Vec<Designed>,
    /// The strategies.
    pub shipped: Vec<Shipped>,
}

impl Validation {
    /// Evaluates designs of the archive. `done` receives the number of runs of each.
    ///
    /// # Errors
    /// [`Stopped`] if `stop` was set.
    pub fn of(
        problem: &Problem,
        (training, fresh): (&Training, &Fresh),
        state: &State,
        (shown, knee): (&[usize], Option<usize>),
        (stop, done): (&AtomicBool, &(dyn Fn(u64) + Sync)),
    ) -> Result<Self, Stopped> {
        let goals = &problem.goals;
        let mut shown = shown.to_vec();
        let cost = |index: &usize| state.archive[*index].point(goals).objectives[0];
        shown.sort_by(|a, b| cost(a).total_cmp(&cost(b)));
        let on_fresh = Evaluator::new(goals, &problem.free, &fresh.population, fresh.without.clone());
        let on_training = training.evaluator(problem);
        let references: Vec<Evaluator<'_>> = fresh
            .references
            .iter()
            .map(|reference| Evaluator::new(goals, &[], &reference.population, fresh.without.clone()))
            .collect();
        let units = 2 * shown.len() + references.len();
        let evaluations: Option<Vec<Evaluation>> = map(units, |unit| {
            if stop.load(Ordering::Relaxed) {
                return None;
            }
            let coordinates = |place: usize| &state.archive[shown[place]].coordinates[..];
            let evaluation = match unit {
                unit if unit < shown.len() => on_fresh.evaluate(coordinates(unit), None),
                // The values of single runs are not stored with the search.
                unit if unit < 2 * shown.len() => on_training.evaluate(coordinates(unit - shown.len()), None),
                unit => references[unit - 2 * shown.len()].evaluate(&[], None),
            };
            done(evaluation.runs);
            Some(evaluation)
        })
        .into_iter()
        .collect();
        let evaluations = evaluations.ok_or(Stopped)?;
        let (of_designs, of_references) = evaluations.split_at(2 * shown.len());
        let (on_fresh, on_training) = of_designs.split_at(shown.len());
        let resamples = |population: &Population| Resamples::of(population.clusters(), problem.seed ^ RESAMPLING);
        let (of_fresh, of_training) = (resamples(&fresh.population), resamples(&training.population));
        let resampled = |evaluation: &Evaluation, resamples: &Resamples| -> Resampled {
            goals
                .quantities()
                .zip(&evaluation.samples)
                .map(|((_, how), samples)| resamples.values(samples, how))
                .collect()
        };
        let fresh_values: Vec<Resampled> = map(on_fresh.len(), |place| resampled(&on_fresh[place], &of_fresh));
        let training_values: Vec<Resampled> =
            map(on_training.len(), |place| resampled(&on_training[place], &of_training));
        let estimates = |values: &Resampled| -> Estimates { values.iter().map(estimate).collect() };
        let design = |(place, &index): (usize, &usize)| Designed {
            name: format!("{:02}", place + 1),
            candidate: state.archive[index].clone(),
            training: estimates(&training_values[place]),
            validation: estimates(&fresh_values[place]),
            diverged: on_fresh[place].diverged,
            is_knee: knee == Some(index),
        };
        let knee_place = shown.iter().position(|index| knee == Some(*index));
        let reference_values: Vec<Resampled> =
            map(of_references.len(), |place| resampled(&of_references[place], &of_fresh));
        let reference = |(place, reference): (usize, &Reference)| {
            let (values, evaluation) = (&reference_values[place], &of_references[place]);
            let is_complete = evaluation.ended == Ended::Complete;
            let point =
                super::Goals { certified: None, ..goals.clone() }.point(&evaluation.values, 0.0, evaluation.diverged);
            let differences = match knee_place {
                Some(knee) => fresh_values[knee].iter().zip(values).map(|(a, b)| difference(a, b)).collect(),
                None => vec![],
            };
            Shipped {
                name: reference.name,
                validation: estimates(values),
                diverged: evaluation.diverged,
                is_feasible: is_complete && point.violation <= 0.0,
                differences: differences.into_iter().take(goals.objectives.len()).collect(),
            }
        };
        Ok(Self {
            designs: shown.iter().enumerate().map(design).collect(),
            shipped: fresh.references.iter().enumerate().map(reference).collect(),
        })
    }
}

/// For each quantity, its value and those of the resamples.
type Resampled = Vec<(Option<f64>, Vec<Option<f64>>)>;
