use std::sync::{Mutex, PoisonError};

use serde::{Deserialize, Serialize};

use super::goals::Goals;
use super::loops::Loops;
use super::nsga::Point;
use super::population::Population;
use super::quantity::{Quantity, Samples};
use super::race::Race;
use crate::run::{RunError, run_pack_sharing};
use crate::sweep::Axis;
use trocar_engine::sensor::NoiseBank;
use trocar_metrics::Outcome;
use trocar_scenario::{CaseFactory, Scenario, Value};

/// 64 MB over all threads.
const MAX_NUMBERS_KEPT: usize = 8 << 20;

/// Divisors of the patients after which a candidate can be stopped.
const PARTS: [usize; 3] = [4, 2, 1];

const LANES: usize = crate::run::PACK;

#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Ended {
    Complete,
    /// Stopped after a part of the patients.
    Stopped,
    Refused(String),
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Evaluation {
    /// From 0 to below 1.
    pub coordinates: Vec<f64>,
    pub ended: Ended,
    pub runs: u64,
    /// Share of the runs.
    pub diverged: f64,
    /// Share of the loops that a cheap condition excludes from a certificate.
    pub without_certificate: f64,
    pub values: Vec<Option<f64>>,
    /// Empty after the selection of a generation, except for its survivors.
    pub samples: Vec<Samples>,
}

impl Evaluation {
    /// Only complete evaluations are comparable; any other is the worst.
    pub fn point(&self, goals: &Goals) -> Point {
        match self.ended {
            Ended::Complete => goals.point(&self.values, self.without_certificate, self.diverged),
            Ended::Stopped | Ended::Refused(_) => {
                Point { objectives: vec![f64::INFINITY; goals.objectives.len()], violation: f64::INFINITY }
            }
        }
    }
}

pub(super) struct Evaluator<'a> {
    goals: &'a Goals,
    free: &'a [Axis],
    population: &'a Population,
    quantities: Vec<Quantity>,
    /// Number of ruptures of each run without augmentation; empty if not needed.
    without: Vec<u64>,
    loops: Option<Loops>,
    workers: Mutex<Vec<Worker<'a>>>,
}

struct Worker<'a> {
    bank: NoiseBank,
    factories: Vec<CaseFactory<'a>>,
}

impl<'a> Evaluator<'a> {
    pub(super) fn new(goals: &'a Goals, free: &'a [Axis], population: &'a Population, without: Vec<u64>) -> Self {
        let quantities: Vec<Quantity> = goals.quantities().map(|(quantity, _)| quantity.clone()).collect();
        let loops = Loops::of(free, &quantities, goals.certified.is_some());
        Self { goals, free, population, quantities, without, loops, workers: Mutex::default() }
    }

    pub(super) fn evaluate(&self, coordinates: &[f64], race: Option<&Race<'_>>) -> Evaluation {
        let stored = self.workers.lock().unwrap_or_else(PoisonError::into_inner).pop();
        let mut worker = stored.unwrap_or_else(|| Worker {
            bank: NoiseBank::new(MAX_NUMBERS_KEPT / rayon::current_num_threads().max(1)),
            factories: self.population.factories(),
        });
        let evaluation = self.evaluate_with(&mut worker, coordinates, race);
        self.workers.lock().unwrap_or_else(PoisonError::into_inner).push(worker);
        evaluation
    }

    fn evaluate_with(&self, worker: &mut Worker<'_>, coordinates: &[f64], race: Option<&Race<'_>>) -> Evaluation {
        let values: Vec<Value> =
            self.free.iter().zip(coordinates).map(|(axis, coordinate)| axis.value(*coordinate)).collect();
        let mut evaluation = Evaluation {
            coordinates: coordinates.to_vec(),
            ended: Ended::Complete,
            runs: 0,
            diverged: 0.0,
            without_certificate: 0.0,
            values: vec![],
            samples: vec![Samples::default(); self.quantities.len()],
        };
        let (mut diverged, mut without_certificate, mut first) = (0_u64, 0_usize, 0);
        let persons = self.population.persons_of_patient();
        for end in self.parts() {
            let part = self.part(worker, first..end, &values, coordinates).and_then(|part| {
                without_certificate += part.without_certificate;
                self.run(worker, &part, first, &mut evaluation, &mut diverged)
            });
            if let Err(error) = part {
                return Evaluation { ended: Ended::Refused(error.to_string()), samples: vec![], ..evaluation };
            }
            first = end;
            evaluation.diverged = diverged as f64 / evaluation.runs.max(1) as f64;
            evaluation.without_certificate = without_certificate as f64 / (end * persons).max(1) as f64;
            if end < self.population.patients() && race.is_some_and(|race| race.is_hopeless(&evaluation)) {
                return Evaluation { ended: Ended::Stopped, samples: vec![], ..evaluation };
            }
        }
        evaluation.values = self.goals.values(&evaluation.samples);
        evaluation
    }

    /// Ascending; whole packs of lanes if possible.
    fn parts(&self) -> Vec<usize> {
        let (all, of_patient) = (self.population.patients(), self.population.runs_of_patient());
        let step = (1..=LANES).find(|patients| (patients * of_patient).is_multiple_of(LANES)).unwrap_or(1);
        let mut parts: Vec<usize> =
            PARTS.iter().map(|part| all.div_ceil(*part).next_multiple_of(step).min(all)).collect();
        parts.dedup();
        parts
    }

    fn part(
        &self,
        worker: &mut Worker<'_>,
        patients: std::ops::Range<usize>,
        values: &[Value],
        coordinates: &[f64],
    ) -> Result<Part, RunError> {
        let persons = self.population.persons_of_patient();
        let mut part = Part { scenarios: vec![], of_loop: vec![], without_certificate: 0 };
        for patient in patients {
            let firsts = self.population.with_persons(&mut worker.factories[patient], patient, values)?;
            for (person, scenario) in firsts.iter().enumerate() {
                let facts = self.loops.as_ref().map(|of| of.facts(patient * persons + person, coordinates, scenario));
                let may_be = facts.as_ref().is_some_and(|facts| facts.may_be_certified(scenario));
                part.without_certificate += usize::from(self.goals.certified.is_some() && !may_be);
                part.of_loop.push(facts);
            }
            part.scenarios.extend(self.population.with_seeds(patient, &firsts));
        }
        Ok(part)
    }

    fn run(
        &self,
        worker: &mut Worker<'_>,
        part: &Part,
        first: usize,
        evaluation: &mut Evaluation,
        diverged: &mut u64,
    ) -> Result<(), RunError> {
        let seeds = part.scenarios.len() / part.of_loop.len().max(1);
        let before = first * self.population.runs_of_patient();
        for (run, metrics) in run_pack_sharing(&mut worker.bank, &part.scenarios).into_iter().enumerate() {
            let metrics = metrics?;
            evaluation.runs += 1;
            *diverged += u64::from(matches!(metrics.outcome, Outcome::Diverged { .. }));
            let without = self.without.get(before + run).copied().unwrap_or(0);
            let of_loop = part.of_loop[run / seeds.max(1)].as_ref();
            for (index, (quantity, samples)) in self.quantities.iter().zip(&mut evaluation.samples).enumerate() {
                samples.push(quantity.read(&metrics, without, of_loop.and_then(|facts| facts.values[index])));
            }
        }
        Ok(())
    }
}

struct Part {
    scenarios: Vec<Scenario>,
    /// One per patient and person.
    of_loop: Vec<Option<std::sync::Arc<super::loops::LoopFacts>>>,
    without_certificate: usize,
}
