use std::collections::{BTreeMap, HashSet};
use std::sync::atomic::AtomicBool;

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use serde::{Deserialize, Serialize};

use super::evaluate::{Ended, Evaluation, Evaluator};
use super::nsga::{Gene, Point, child, front, hypervolume, standings, survivors};
use super::patients::Patients;
use super::problem::Problem;
use super::race::Race;
use crate::sweep::{Permutation, mix};
use trocar_base::parallel::map_unless;

const ATTEMPTS: usize = 8;

/// The search continues from it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct State {
    pub design_sha256: String,
    pub generations: u64,
    pub parents: Vec<Evaluation>,
    /// By generation, without values of runs.
    pub archive: Vec<Evaluation>,
    /// Size of the archive after each generation.
    pub archived: Vec<usize>,
    pub runs: u64,
    pub stopped: u64,
    pub refused: u64,
    pub first_refusal: Option<String>,
    /// True if found; keys are the SHA-256 of all that a certificate depends on.
    pub certificates: BTreeMap<String, bool>,
}

impl State {
    pub fn new(problem: &Problem) -> Self {
        Self {
            design_sha256: problem.hash(),
            generations: 0,
            parents: vec![],
            archive: vec![],
            archived: vec![],
            runs: 0,
            stopped: 0,
            refused: 0,
            first_refusal: None,
            certificates: BTreeMap::new(),
        }
    }

    /// `None` if the text is invalid, or of another design.
    pub fn stored(text: &str, problem: &Problem) -> Option<Self> {
        serde_json::from_str(text).ok().filter(|state: &Self| state.design_sha256 == problem.hash())
    }

    pub fn to_json(&self) -> String {
        serde_json::to_string(self).unwrap_or_default() + "\n"
    }

    pub fn is_complete(&self, problem: &Problem) -> bool {
        self.generations >= problem.search.generations
    }

    pub fn points(&self, problem: &Problem) -> Vec<Point> {
        self.archive.iter().map(|evaluation| evaluation.point(&problem.goals)).collect()
    }
}

/// The stopped generation is lost.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Stopped;

pub struct Search<'a> {
    problem: &'a Problem,
    training: &'a Patients,
    evaluator: Evaluator<'a>,
    genes: Vec<Gene>,
}

impl<'a> Search<'a> {
    pub fn new(problem: &'a Problem, training: &'a Patients) -> Self {
        Self { problem, training, evaluator: training.evaluator(problem), genes: problem.genes() }
    }

    /// Runs of a candidate that is not stopped early.
    pub fn runs_of_candidate(&self) -> usize {
        self.training.population().runs()
    }

    /// The result does not depend on the threads. If `stop` was set, the state is unchanged.
    pub fn advance(&self, state: &mut State, stop: &AtomicBool, done: &(dyn Fn(u64) + Sync)) -> Result<(), Stopped> {
        let children = match state.generations {
            0 => self.first(),
            _ => self.children(state),
        };
        let race = match state.generations {
            0 => None,
            _ => Race::among(&self.problem.goals, &state.parents, self.training.population().runs_of_patient()),
        };
        let evaluate = |index: usize| {
            let evaluation = self.evaluator.evaluate(&children[index], race.as_ref());
            done(evaluation.runs);
            evaluation
        };
        let evaluations = map_unless(stop, children.len(), evaluate).ok_or(Stopped)?;
        for evaluation in &evaluations {
            state.runs += evaluation.runs;
            match &evaluation.ended {
                Ended::Complete => state.archive.push(Evaluation { samples: vec![], ..evaluation.clone() }),
                Ended::Stopped => state.stopped += 1,
                Ended::Refused(reason) => {
                    state.refused += 1;
                    state.first_refusal.get_or_insert_with(|| reason.clone());
                }
            }
        }
        let complete = |evaluation: &Evaluation| evaluation.ended == Ended::Complete;
        let mut all = std::mem::take(&mut state.parents);
        all.extend(evaluations.into_iter().filter(complete));
        let points: Vec<Point> = all.iter().map(|evaluation| evaluation.point(&self.problem.goals)).collect();
        let mut all: Vec<Option<Evaluation>> = all.into_iter().map(Some).collect();
        let kept = survivors(&points, self.problem.search.candidates);
        state.parents = kept.into_iter().filter_map(|index| all[index].take()).collect();
        state.archived.push(state.archive.len());
        state.generations += 1;
        Ok(())
    }

    /// Latin hypercube over the free keys.
    fn first(&self) -> Vec<Vec<f64>> {
        use rand::RngExt;
        let (count, seed) = (self.problem.search.candidates as u64, self.problem.search.seed);
        let orders: Vec<Permutation> =
            (0..self.genes.len()).map(|gene| Permutation::new(count, mix(seed ^ mix(gene as u64)))).collect();
        let coordinates = |index: u64| {
            let mut random = self.stream(0, index as usize);
            orders.iter().map(|order| (order.at(index) as f64 + random.random::<f64>()) / count as f64).collect()
        };
        (0..count).map(coordinates).collect()
    }

    fn children(&self, state: &State) -> Vec<Vec<f64>> {
        let goals = &self.problem.goals;
        let points: Vec<Point> = state.parents.iter().map(|parent| parent.point(goals)).collect();
        let standings = standings(&points);
        let parents: Vec<&[f64]> = state.parents.iter().map(|parent| &parent.coordinates[..]).collect();
        if parents.is_empty() {
            // No candidate so far was a valid scenario.
            return (0..self.problem.search.candidates).map(|index| self.random(state.generations, index)).collect();
        }
        let mut known: HashSet<Vec<u64>> = state.archive.iter().map(|one| self.identity(&one.coordinates)).collect();
        let new = |index: usize| {
            let mut random = self.stream(state.generations, index);
            let mut create = || child(&self.genes, &parents, &standings, &mut random);
            let mut candidate = create();
            for _ in 0..ATTEMPTS {
                if known.insert(self.identity(&candidate)) {
                    break;
                }
                candidate = create();
            }
            candidate
        };
        (0..self.problem.search.candidates).map(new).collect()
    }

    fn random(&self, generation: u64, index: usize) -> Vec<f64> {
        use rand::RngExt;
        let mut random = self.stream(generation, index);
        self.genes.iter().map(|_| random.random()).collect()
    }

    fn stream(&self, generation: u64, index: usize) -> ChaCha8Rng {
        let mut random = ChaCha8Rng::seed_from_u64(self.problem.search.seed);
        random.set_stream(generation << 32 | index as u64);
        random
    }

    /// Equal for candidates with the same values.
    fn identity(&self, coordinates: &[f64]) -> Vec<u64> {
        let of_gene = |(gene, coordinate): (&Gene, &f64)| match gene {
            Gene::Number => coordinate.to_bits(),
            Gene::Choice(_) => gene.choice(*coordinate),
        };
        self.genes.iter().zip(coordinates).map(of_gene).collect()
    }
}

const MAX_OBJECTIVES: usize = 4;
const MAX_POINTS: usize = 500;

impl State {
    /// Volume of the front after three quarters of the generations, as a share of the final one.
    pub fn settled_share(&self, problem: &Problem) -> Option<f64> {
        let points = self.points(problem);
        let last = front(&points);
        let early = self.archived.get((3 * self.archived.len() / 4).checked_sub(1)?)?;
        let early = front(&points[..*early]);
        let objectives = problem.goals.objectives.len();
        if objectives > MAX_OBJECTIVES || last.len().max(early.len()) > MAX_POINTS {
            return None;
        }
        let bound = |objective: usize| {
            let values = || last.iter().map(|&index| points[index].objectives[objective]);
            let (low, high) = (values().fold(f64::INFINITY, f64::min), values().fold(f64::NEG_INFINITY, f64::max));
            high + 0.1 * (high - low)
        };
        let bounds: Vec<f64> = (0..objectives).map(bound).collect();
        let volume = |front: &[usize]| {
            let front: Vec<&[f64]> = front.iter().map(|&index| &points[index].objectives[..]).collect();
            hypervolume(&front, &bounds)
        };
        let whole = volume(&last);
        (whole > 0.0 && whole.is_finite()).then(|| volume(&early) / whole)
    }
}

/// Leaves out the refused candidates.
pub fn front_of(points: &[Point], refused: &HashSet<usize>) -> Vec<usize> {
    let mut points = points.to_vec();
    refused.iter().for_each(|&index| points[index].violation = f64::INFINITY);
    let first_of_equals = |index: &usize| !points[..*index].iter().any(|other| *other == points[*index]);
    front(&points).into_iter().filter(first_of_equals).collect()
}
