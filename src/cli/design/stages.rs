//! The stages of a design: search, certificates, validation. The state is stored after each generation and after the
//! certificates.

use std::sync::atomic::AtomicBool;

use super::SEARCH;
use crate::cli::error::CliError;
use crate::cli::progress;
use trocar_report::{Folder, write_file};
use trocar_studies::design::{Certification, Front, Patients, Problem, Search, State, Stopped, Use, Validation};

pub(super) struct Stages<'a> {
    pub(super) problem: &'a Problem,
    pub(super) folder: &'a Folder,
    pub(super) stop: &'a AtomicBool,
    pub(super) quiet: bool,
}

/// The error of a stopped search.
pub(super) fn interrupted(folder: &Folder, kept: &str) -> CliError {
    CliError::Interrupted {
        kept: Some(format!("{kept} kept in {}; run the same command to continue", folder.path.display())),
    }
}

impl Stages<'_> {
    /// The patients of the search, and the other ones.
    pub(super) fn populations(&self) -> Result<(Patients, Patients), CliError> {
        let (training, fresh) =
            rayon::join(|| Patients::of(self.problem, Use::Training), || Patients::of(self.problem, Use::Validation));
        Ok((training?, fresh?))
    }

    pub(super) fn search(&self, training: &Patients, state: &mut State) -> Result<(), CliError> {
        let search = Search::new(self.problem, training);
        let all = self.problem.search.generations;
        let bar = progress::rated_bar(
            (all as usize).saturating_mul(self.problem.search.candidates).saturating_mul(search.runs_of_candidate()),
            self.quiet,
        );
        let (candidates, runs) = (self.problem.search.candidates as u64, search.runs_of_candidate() as u64);
        let place = |generations: u64| generations * candidates * runs;
        bar.set_position(place(state.generations));
        bar.reset_eta();
        while !state.is_complete(self.problem) {
            bar.set_message(format!("generation {}", state.generations + 1));
            let advanced = search.advance(state, self.stop, &|runs| bar.inc(runs));
            if let Err(Stopped) = advanced {
                bar.finish_and_clear();
                return Err(interrupted(self.folder, &format!("{} of {all} generations are", state.generations)));
            }
            // Candidates that were stopped early have fewer runs.
            bar.set_position(place(state.generations));
            self.store(state)?;
        }
        bar.finish_and_clear();
        Ok(())
    }

    pub(super) fn certify(&self, training: &Patients, fresh: &Patients, state: &mut State) -> Result<Front, CliError> {
        let certification = Certification::new(self.problem, vec![training.population(), fresh.population()]);
        let bar = progress::counter(self.quiet || self.problem.goals.certified.is_none());
        bar.set_message("certificates");
        loop {
            let (front, is_open) = certification.front(state)?;
            if !is_open {
                bar.finish_and_clear();
                return Ok(front);
            }
            if self.stop.load(std::sync::atomic::Ordering::Relaxed) {
                bar.finish_and_clear();
                return Err(interrupted(self.folder, "the search and the certificates so far are"));
            }
            // As many at once as there are threads, so that an interruption loses little.
            certification.certify(state, &front.shown, rayon::current_num_threads(), &|| bar.inc(1))?;
            self.store(state)?;
        }
    }

    pub(super) fn validate(
        &self,
        (training, fresh): (&Patients, &Patients),
        state: &State,
        front: &Front,
    ) -> Result<Validation, CliError> {
        let bar = progress::rated_bar(Validation::runs(fresh, front.shown.len()), self.quiet);
        bar.set_message("other patients");
        let progress = (self.stop, &(|runs| bar.inc(runs)) as &(dyn Fn(u64) + Sync));
        let validation = Validation::of(self.problem, (training, fresh), state, (&front.shown, front.knee), progress);
        bar.finish_and_clear();
        validation.map_err(|Stopped| interrupted(self.folder, "the search is"))
    }

    fn store(&self, state: &State) -> Result<(), CliError> {
        Ok(write_file(&self.folder.path.join(SEARCH), state.to_json().as_bytes())?)
    }
}
