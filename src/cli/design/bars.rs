use std::sync::{Mutex, PoisonError};

use indicatif::ProgressBar;

use super::SEARCH;
use crate::cli::progress;
use trocar_report::{Folder, OutputError, write_file};
use trocar_studies::design::{Follower, Stage, State};

pub(super) struct Bars<'a> {
    folder: &'a Folder,
    quiet: bool,
    bar: Mutex<ProgressBar>,
}

impl<'a> Bars<'a> {
    pub(super) fn new(folder: &'a Folder, quiet: bool) -> Self {
        Self { folder, quiet, bar: Mutex::new(ProgressBar::hidden()) }
    }

    pub(super) fn clear(&self) {
        self.bar().finish_and_clear();
    }

    fn bar(&self) -> std::sync::MutexGuard<'_, ProgressBar> {
        self.bar.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Follower for Bars<'_> {
    type Error = OutputError;

    fn at(&self, stage: Stage, done: u64, all: u64) {
        let mut bar = self.bar();
        let message = match stage {
            Stage::Generation(generation) => format!("generation {generation}"),
            Stage::Certificates => "certificates".to_owned(),
            Stage::OtherPatients => "other patients".to_owned(),
        };
        let is_next_generation = matches!(stage, Stage::Generation(_)) && bar.length() == Some(all);
        if !is_next_generation {
            bar.finish_and_clear();
            *bar = match stage {
                Stage::Certificates => progress::counter(self.quiet),
                Stage::Generation(_) | Stage::OtherPatients => progress::rated_bar(all as usize, self.quiet),
            };
        }
        bar.set_position(done);
        bar.set_message(message);
        if !is_next_generation {
            bar.reset_eta();
        }
    }

    fn advance(&self, units: u64) {
        self.bar().inc(units);
    }

    fn keep(&self, state: &State) -> Result<(), OutputError> {
        write_file(&self.folder.path.join(SEARCH), state.to_json().as_bytes())
    }
}
