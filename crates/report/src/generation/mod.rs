//! One generation of output: all files that a command writes, stored as a whole.
//!
//! # Invariant
//! At any moment, also after the end of the process or of power, every folder of a generation is the old one or the
//! new one, as seen by the next trocar command and by the folder's [`Manifest`]. Files that trocar has not written
//! stay. A generation goes through these states:
//!
//! 1. *Staged.* The command writes into `.trocar-XXXXXX` within the output folder. The results are untouched. A lock
//!    of the operating system on the file `lock` in it lives as long as the process; `claims` names the folders that
//!    the command will replace. A second command with such a folder is refused.
//! 2. *Synced.* Every file, its folder and the new manifests reach the disk.
//! 3. *Decided.* The file `journal.json` is renamed to its name. It lists every move. This is the only step that
//!    decides: before it, the next command removes the stage; after it, the next command completes the moves.
//! 4. *Moved.* Each folder is exchanged with its new one in one step where the operating system can ([`swap`]). Else
//!    its files are moved one by one, the manifest last, and files of the former generation are removed.
//! 5. *Removed.* The journal, then the stage.
//!
//! Steps 3 to 5, the recovery and the start of a command hold the lock `.trocar-lock` of the output folder, for
//! milliseconds.
//!
//! A plain reader can see a mixture of two generations for the fraction of a millisecond of step 4 in three cases:
//! the files are directly in the output folder, where other commands have their folders; the folder contains
//! subfolders, links, or files of another owner; the file system cannot exchange folders. File systems without locks
//! are not protected against two commands at once, and leftovers on them stay.

mod journal;
mod live;
mod lock;
mod manifest;
mod ops;
mod plan;
mod recovery;
mod swap;
#[cfg(test)]
mod tests;

use std::collections::BTreeMap;
use std::fs::File;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

use rayon::prelude::*;
use serde_json::{Map, Value as Json};

pub use live::discard_all;
pub use manifest::{Difference, MANIFEST, Manifest, ManifestError, ManifestFile, StoredFile};
pub(super) use ops::sync_folder;
pub use recovery::recover;
pub(super) use recovery::remove_left_files;

use super::OutputError;
use journal::{JOURNAL, Journal};

/// Begins the names of everything temporary.
pub(crate) const TEMPORARY: &str = ".trocar-";

const LOCK: &str = "lock";
const CLAIMS: &str = "claims";

/// The files of a command until they replace those of a former one.
#[derive(Debug)]
pub(super) struct Generation {
    root: PathBuf,
    stage: PathBuf,
    /// True if the output folder was created for this generation.
    made_root: bool,
    /// Locked until the process ends.
    _lock: File,
    state: Mutex<State>,
}

#[derive(Debug, Default)]
struct State {
    units: Vec<Unit>,
    is_over: bool,
}

/// A folder of a generation.
#[derive(Debug)]
struct Unit {
    /// The path within the output folder, with `/`; empty for the output folder itself.
    name: String,
    command: &'static str,
    files: BTreeMap<String, StoredFile>,
    /// Further fields of the manifest.
    details: Map<String, Json>,
}

/// True if two commands with these folders exclude each other. A folder does not include its subfolders.
fn is_claimed(claims: &[String], name: &str) -> bool {
    claims.iter().any(|claim| claim == name)
}

impl Generation {
    /// Begins a generation of the folders `units` within `root`: completes or removes the leftovers of killed
    /// commands, and claims the folders.
    pub(super) fn begin(root: &Path, command: &'static str, units: &[&str]) -> Result<Self, OutputError> {
        let failed = |source| OutputError::Write { path: root.to_owned(), source };
        let made_root = !root.exists();
        ops::create_folder(root).map_err(failed)?;
        let exclusive = lock::exclusive(root)?;
        let claims = recovery::recover_locked(root)?;
        if let Some(name) = units.iter().find(|name| is_claimed(&claims, name)) {
            return Err(OutputError::Busy { path: root.join(name) });
        }
        let stage = tempfile::Builder::new().prefix(TEMPORARY).tempdir_in(root).map_err(failed)?.keep();
        let lock = File::options().write(true).create(true).truncate(false).open(stage.join(LOCK)).map_err(failed)?;
        // File systems without locks are not protected.
        let _ = lock.try_lock();
        let state = Mutex::default();
        let generation = Self { root: root.to_owned(), stage, made_root, _lock: lock, state };
        live::add(&generation);
        for name in units {
            generation.claim(&mut generation.state(), name, command);
        }
        generation.write_claims(&generation.state())?;
        drop(exclusive);
        Ok(generation)
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn claim(&self, state: &mut State, name: &str, command: &'static str) -> usize {
        let unit = Unit { name: name.to_owned(), command, files: BTreeMap::new(), details: Map::new() };
        state.units.push(unit);
        state.units.len() - 1
    }

    fn write_claims(&self, state: &State) -> Result<(), OutputError> {
        let names: Vec<&str> = state.units.iter().map(|unit| unit.name.as_str()).collect();
        let path = self.stage.join(CLAIMS);
        // A list of names is always valid JSON.
        let text = serde_json::to_string(&names).unwrap_or_default();
        ops::write(&path, text.as_bytes()).map_err(|source| OutputError::Write { path, source })
    }

    /// Returns the index of a folder, and claims it if it is new.
    fn index(&self, state: &mut State, name: &str, command: &'static str) -> Result<usize, OutputError> {
        if let Some(index) = state.units.iter().position(|unit| unit.name == name) {
            state.units[index].command = command;
            return Ok(index);
        }
        let _exclusive = lock::exclusive(&self.root)?;
        if is_claimed(&recovery::claims(&self.root, &self.stage), name) {
            return Err(OutputError::Busy { path: self.root.join(name) });
        }
        let index = self.claim(state, name, command);
        self.write_claims(state)?;
        Ok(index)
    }

    /// Returns the path at which a file of a folder is staged.
    pub(super) fn staged(&self, unit: &str, command: &'static str, file: &str) -> Result<PathBuf, OutputError> {
        let index = self.index(&mut self.state(), unit, command)?;
        let path = self.stage.join(index.to_string()).join(file);
        let folder = path.parent().unwrap_or(&self.stage);
        let failed = |source| OutputError::Write { path: self.root.join(unit), source };
        ops::create_folder(folder).map_err(failed)?;
        Ok(path)
    }

    /// Adds a staged file to the generation.
    pub(super) fn add(&self, unit: &str, file: &str, stored: StoredFile) {
        let mut state = self.state();
        if let Some(unit) = state.units.iter_mut().find(|one| one.name == unit) {
            unit.files.insert(file.to_owned(), stored);
        }
    }

    /// Removes the added files of a folder.
    pub(super) fn discard(&self, unit: &str) {
        if let Some(unit) = self.state().units.iter_mut().find(|one| one.name == unit) {
            unit.files.clear();
        }
    }

    /// Sets further fields of a folder's manifest.
    pub(super) fn describe(&self, unit: &str, details: Map<String, Json>) {
        if let Some(unit) = self.state().units.iter_mut().find(|one| one.name == unit) {
            unit.details = details;
        }
    }

    /// Replaces the former generation. Nothing has changed if this fails before the journal is written.
    pub(super) fn commit(&self) -> Result<(), OutputError> {
        let mut state = self.state();
        if state.is_over {
            return Ok(());
        }
        // Ctrl-C waits for the end of the commit.
        let _live = live::hold();
        let failed = |source| OutputError::Write { path: self.root.clone(), source };
        self.sync(&state).map_err(failed)?;
        let units = state.units.iter().enumerate().filter(|(_, unit)| !unit.files.is_empty());
        let below: Vec<(&str, &str)> = units
            .clone()
            .map(|(_, unit)| (unit.name.as_str(), unit.command))
            .filter(|(name, _)| !name.is_empty())
            .collect();
        let plan = |(index, unit): (usize, &Unit)| {
            let folders = if unit.name.is_empty() { below.as_slice() } else { &[] };
            plan::plan(&self.root, &self.stage, index, unit, folders)
        };
        let journal = Journal { units: units.map(plan).collect::<Result<_, _>>()? };
        ops::sync_folder(&self.stage).map_err(failed)?;
        let _exclusive = lock::exclusive(&self.root)?;
        journal.decide(&self.stage).map_err(failed)?;
        state.is_over = true;
        live::remove(&self.stage);
        let unfinished = |source| OutputError::Unfinished { stage: self.stage.clone(), source };
        journal.apply(&self.root, &self.stage).map_err(unfinished)?;
        recovery::remove(&self.stage).map_err(unfinished)
    }

    fn sync(&self, state: &State) -> std::io::Result<()> {
        let of_unit = |(index, unit): (usize, &Unit)| {
            let folder = self.stage.join(index.to_string());
            unit.files.keys().map(|name| folder.join(name)).collect::<Vec<_>>()
        };
        let files: Vec<PathBuf> = state.units.iter().enumerate().flat_map(of_unit).collect();
        ops::all(&files, |files| files.par_iter().try_for_each(|file| ops::sync_file(file)))
    }
}

impl Drop for Generation {
    fn drop(&mut self) {
        live::remove(&self.stage);
        if !self.state().is_over && !ops::is_crashed() {
            // The next command removes what cannot be removed now.
            let _ = recovery::remove(&self.stage);
            if self.made_root {
                let _ = std::fs::remove_dir(&self.root);
            }
        }
    }
}

/// The path of the journal of a stage.
fn journal_path(stage: &Path) -> PathBuf {
    stage.join(JOURNAL)
}
