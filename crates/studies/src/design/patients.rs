use super::evaluate::Evaluator;
use super::population::{Population, Use};
use super::problem::Problem;
use crate::run::{RunError, run_pack_sharing};
use trocar_base::parallel::try_map;
use trocar_engine::sensor::NoiseBank;
use trocar_scenario::ScenarioError;

#[derive(Debug)]
pub struct Patients {
    population: Population,
    without: Vec<u64>,
}

impl Patients {
    pub fn of(problem: &Problem, used: Use) -> Result<Self, RunError> {
        let population = Population::of(problem, used, &problem.free, &[])?;
        Ok(Self { population, without: ruptures_without_augmentation(problem, used)? })
    }

    pub fn population(&self) -> &Population {
        &self.population
    }

    pub(super) fn evaluator<'a>(&'a self, problem: &'a Problem) -> Evaluator<'a> {
        Evaluator::new(&problem.goals, &problem.free, &self.population, self.without.clone())
    }

    pub(super) fn reference_evaluator<'a>(&self, problem: &'a Problem, population: &'a Population) -> Evaluator<'a> {
        Evaluator::new(&problem.goals, &[], population, self.without.clone())
    }
}

/// Empty if no goal is relative to them.
fn ruptures_without_augmentation(problem: &Problem, used: Use) -> Result<Vec<u64>, RunError> {
    if !problem.goals.quantities().any(|(quantity, _)| quantity.is_relative()) {
        return Ok(vec![]);
    }
    let population = reference_population(problem, used, &["augmentation.enabled=false"])?;
    let of_patient = |patient: usize| -> Result<Vec<u64>, RunError> {
        let mut factories = population.factory(patient);
        let firsts = population.with_persons(&mut factories, patient, &[])?;
        let scenarios = population.with_seeds(patient, &firsts);
        let runs = run_pack_sharing(&mut NoiseBank::new(0), &scenarios);
        runs.into_iter().map(|metrics| metrics.map(|metrics| metrics.ruptures.len() as u64)).collect()
    };
    Ok(try_map(population.patients(), of_patient)?.concat())
}

/// The settings replace those of the design for the events.
pub(super) fn reference_population(
    problem: &Problem,
    used: Use,
    settings: &[&str],
) -> Result<Population, ScenarioError> {
    let settings: Vec<String> = settings.iter().map(|&setting| setting.to_owned()).collect();
    Population::of(problem, used, &[], &settings)
        // The fixed keys may have no effect with these settings.
        .or_else(|_| Population::of(&problem.without_fixed("augmentation."), used, &[], &settings))
}
