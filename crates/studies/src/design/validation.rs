use std::sync::atomic::AtomicBool;

use super::bootstrap::{Estimate, Resamples, difference, estimate};
use super::evaluate::{Ended, Evaluation};
use super::patients::{Patients, reference_population};
use super::population::{Population, Use};
use super::problem::Problem;
use super::quantity::Aggregate;
use super::search::{State, Stopped};
use crate::compare::{STRATEGIES, Strategy};
use trocar_base::parallel::{map, map_unless};

/// Separates these random numbers from others with the same seed.
const RESAMPLING: u64 = 0x626f_6f74;

pub type Estimates = Vec<Option<Estimate>>;

#[derive(Debug, Clone, PartialEq)]
pub struct Designed {
    pub name: String,
    pub candidate: Evaluation,
    pub training: Estimates,
    pub validation: Estimates,
    /// Share of the runs on other patients.
    pub diverged: f64,
    pub is_knee: bool,
}

/// A shipped strategy on the same other patients.
#[derive(Debug, Clone, PartialEq)]
pub struct Shipped {
    pub name: &'static str,
    pub validation: Estimates,
    pub diverged: f64,
    /// True if no constraint on a quantity is violated.
    pub is_feasible: bool,
    /// Knee minus strategy, for each objective, over paired resamples.
    pub differences: Estimates,
}

#[derive(Debug, Clone, PartialEq)]
pub struct Validation {
    pub designs: Vec<Designed>,
    pub shipped: Vec<Shipped>,
    /// Strategies that cannot be combined with the scenario, with the reason.
    pub left_out: Vec<(&'static str, String)>,
}

impl Validation {
    /// Designs run on both groups of patients, shipped strategies on the other patients only.
    pub fn runs((training, fresh): (&Patients, &Patients), designs: usize) -> usize {
        designs * training.population().runs() + (designs + STRATEGIES.len()) * fresh.population().runs()
    }

    pub fn of(
        problem: &Problem,
        (training, fresh): (&Patients, &Patients),
        state: &State,
        (shown, knee): (&[usize], Option<usize>),
        (stop, done): (&AtomicBool, &(dyn Fn(u64) + Sync)),
    ) -> Result<Self, Stopped> {
        let goals = &problem.goals;
        let mut shown = shown.to_vec();
        let cost = |index: &usize| state.archive[*index].point(goals).objectives[0];
        shown.sort_by(|a, b| cost(a).total_cmp(&cost(b)));
        let (on_fresh, on_training) = (fresh.evaluator(problem), training.evaluator(problem));
        let units = 2 * shown.len() + STRATEGIES.len();
        let coordinates = |place: usize| &state.archive[shown[place]].coordinates[..];
        let evaluate = |unit: usize| match unit {
            unit if unit < shown.len() => Ok(on_fresh.evaluate(coordinates(unit), None)),
            // The values of single runs are not stored with the search.
            unit if unit < 2 * shown.len() => Ok(on_training.evaluate(coordinates(unit - shown.len()), None)),
            unit => evaluate_strategy(problem, fresh, &STRATEGIES[unit - 2 * shown.len()]),
        };
        let evaluations = map_unless(stop, units, |unit| {
            let evaluation: Result<Evaluation, String> = evaluate(unit);
            done(evaluation.as_ref().map_or(0, |evaluation| evaluation.runs));
            evaluation
        });
        let mut of_designs = evaluations.ok_or(Stopped)?;
        let of_strategies = of_designs.split_off(2 * shown.len());
        let of_designs: Vec<Evaluation> = of_designs.into_iter().flatten().collect();
        let (mut references, mut left_out): (Vec<(&'static str, Evaluation)>, _) = (vec![], vec![]);
        for (strategy, evaluation) in STRATEGIES.iter().zip(of_strategies) {
            match evaluation {
                Ok(evaluation) => references.push((strategy.name, evaluation)),
                Err(reason) => left_out.push((strategy.name, reason)),
            }
        }
        let (on_fresh, on_training) = of_designs.split_at(shown.len());
        let resamples = |population: &Population| Resamples::of(population.clusters(), problem.seed ^ RESAMPLING);
        let (of_fresh, of_training) = (resamples(fresh.population()), resamples(training.population()));
        // A design that is invalid for one of the other patients has no values.
        let resampled = |evaluation: &Evaluation, resamples: &Resamples| -> Resampled {
            let of = |(index, (_, how)): (usize, (_, Aggregate))| match evaluation.samples.get(index) {
                Some(samples) => resamples.values(samples, how),
                None => (None, vec![]),
            };
            goals.quantities().enumerate().map(of).collect()
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
            map(references.len(), |place| resampled(&references[place].1, &of_fresh));
        let reference = |(values, (name, evaluation)): (&Resampled, &(&'static str, Evaluation))| {
            let point =
                super::Goals { certified: None, ..goals.clone() }.point(&evaluation.values, 0.0, evaluation.diverged);
            let differences = match knee_place {
                Some(knee) => fresh_values[knee].iter().zip(values).map(|(a, b)| difference(a, b)).collect(),
                None => vec![],
            };
            Shipped {
                name,
                validation: estimates(values),
                diverged: evaluation.diverged,
                is_feasible: point.violation <= 0.0,
                differences: differences.into_iter().take(goals.objectives.len()).collect(),
            }
        };
        Ok(Self {
            designs: shown.iter().enumerate().map(design).collect(),
            shipped: reference_values.iter().zip(&references).map(reference).collect(),
            left_out,
        })
    }
}

fn evaluate_strategy(problem: &Problem, fresh: &Patients, strategy: &Strategy) -> Result<Evaluation, String> {
    let population =
        reference_population(problem, Use::Validation, strategy.settings).map_err(|error| error.message)?;
    let evaluation = fresh.reference_evaluator(problem, &population).evaluate(&[], None);
    match evaluation.ended {
        Ended::Refused(reason) => Err(reason),
        Ended::Complete | Ended::Stopped => Ok(evaluation),
    }
}

type Resampled = Vec<(Option<f64>, Vec<Option<f64>>)>;
