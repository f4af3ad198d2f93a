use std::sync::atomic::{AtomicBool, Ordering};

use super::certify::{Certification, Front};
use super::document::DesignStudy;
use super::patients::Patients;
use super::population::Use;
use super::problem::Problem;
use super::search::{Search, State, Stopped};
use super::validation::Validation;
use crate::run::RunError;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stage {
    /// Number from 1. The units are runs.
    Generation(u64),
    /// The end is unknown. The units are designs.
    Certificates,
    OtherPatients,
}

pub trait Follower: Sync {
    type Error;

    /// `all` is 0 if the number of units is unknown.
    fn at(&self, stage: Stage, done: u64, all: u64);

    fn advance(&self, units: u64);

    /// Called after every generation and every search for certificates.
    fn keep(&self, state: &State) -> Result<(), Self::Error>;
}

#[derive(Debug)]
pub enum DesignError<E> {
    Run(RunError),
    Stopped(Stage),
    Keep(E),
}

impl<E> From<RunError> for DesignError<E> {
    fn from(error: RunError) -> Self {
        Self::Run(error)
    }
}

#[derive(Debug)]
pub struct Design {
    training: Patients,
    fresh: Patients,
    front: Front,
    validation: Validation,
}

impl Design {
    /// After an error, `state` is the last complete one.
    pub fn of<F: Follower>(
        problem: &Problem,
        state: &mut State,
        stop: &AtomicBool,
        follower: &F,
    ) -> Result<Self, DesignError<F::Error>> {
        let (training, fresh) =
            rayon::join(|| Patients::of(problem, Use::Training), || Patients::of(problem, Use::Validation));
        let (training, fresh) = (training?, fresh?);
        let stages = Stages { problem, stop, follower };
        stages.search(&training, state)?;
        let front = stages.certify(&training, &fresh, state)?;
        let validation = stages.validate((&training, &fresh), state, &front)?;
        Ok(Self { training, fresh, front, validation })
    }

    pub fn study<'a>(&'a self, problem: &'a Problem, state: &'a State) -> DesignStudy<'a> {
        DesignStudy {
            problem,
            state,
            front: &self.front,
            validation: &self.validation,
            fresh: &self.fresh,
            patients: self.training.population().patients(),
        }
    }
}

struct Stages<'a, F> {
    problem: &'a Problem,
    stop: &'a AtomicBool,
    follower: &'a F,
}

impl<F: Follower> Stages<'_, F> {
    fn search(&self, training: &Patients, state: &mut State) -> Result<(), DesignError<F::Error>> {
        let search = Search::new(self.problem, training);
        let of_generation = self.problem.search.candidates as u64 * search.runs_of_candidate() as u64;
        let all = self.problem.search.generations.saturating_mul(of_generation);
        while !state.is_complete(self.problem) {
            let stage = Stage::Generation(state.generations + 1);
            // Candidates that were stopped early have fewer runs.
            self.follower.at(stage, state.generations * of_generation, all);
            let advanced = search.advance(state, self.stop, &|runs| self.follower.advance(runs));
            advanced.map_err(|Stopped| DesignError::Stopped(stage))?;
            self.follower.keep(state).map_err(DesignError::Keep)?;
        }
        Ok(())
    }

    fn certify(
        &self,
        training: &Patients,
        fresh: &Patients,
        state: &mut State,
    ) -> Result<Front, DesignError<F::Error>> {
        let certification = Certification::new(self.problem, vec![training.population(), fresh.population()]);
        if self.problem.goals.certified.is_some() {
            self.follower.at(Stage::Certificates, 0, 0);
        }
        loop {
            let (front, is_open) = certification.front(state)?;
            if !is_open {
                return Ok(front);
            }
            if self.stop.load(Ordering::Relaxed) {
                return Err(DesignError::Stopped(Stage::Certificates));
            }
            // An interruption loses one certificate per thread.
            let at_once = rayon::current_num_threads();
            certification.certify(state, &front.shown, at_once, &|| self.follower.advance(1))?;
            self.follower.keep(state).map_err(DesignError::Keep)?;
        }
    }

    fn validate(
        &self,
        (training, fresh): (&Patients, &Patients),
        state: &State,
        front: &Front,
    ) -> Result<Validation, DesignError<F::Error>> {
        self.follower.at(Stage::OtherPatients, 0, Validation::runs((training, fresh), front.shown.len()) as u64);
        let advance = |runs| self.follower.advance(runs);
        let progress = (self.stop, &advance as &(dyn Fn(u64) + Sync));
        Validation::of(self.problem, (training, fresh), state, (&front.shown, front.knee), progress)
            .map_err(|Stopped| DesignError::Stopped(Stage::OtherPatients))
    }
}
