//! The list of the moves of a generation. Performing it again has no further effect.

use std::collections::BTreeMap;
use std::io;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::manifest::{MANIFEST, StoredFile, sha256};
use super::{TEMPORARY, journal_path, ops, swap};

pub(super) const JOURNAL: &str = "journal.json";

/// The moves of a generation.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct Journal {
    pub(super) units: Vec<UnitJournal>,
}

/// The moves of a folder.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct UnitJournal {
    /// The path within the output folder.
    pub(super) folder: String,
    /// The path within the stage.
    pub(super) staged: String,
    /// The identity of the staged folder, if it can be exchanged as a whole.
    pub(super) exchange: Option<swap::Identity>,
    pub(super) files: Vec<String>,
    /// The files of the former generation to be removed, with their hashes.
    pub(super) stale: BTreeMap<String, String>,
}

/// The name of a copy on the file system of its target. It has the form of every temporary name.
pub(super) fn copy_name(file: &str) -> String {
    format!("{TEMPORARY}{}", &sha256(file.as_bytes())[..6])
}

impl Journal {
    /// Reads a journal; `None` if the stage has none.
    pub(super) fn read(path: &Path) -> io::Result<Option<Self>> {
        match std::fs::read(path) {
            Ok(text) => Ok(Some(serde_json::from_slice(&text)?)),
            Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(None),
            Err(error) => Err(error),
        }
    }

    /// Writes the journal. From here on the new generation is valid.
    pub(super) fn decide(&self, stage: &Path) -> io::Result<()> {
        let (draft, path) = (stage.join("journal.draft"), journal_path(stage));
        ops::write(&draft, &serde_json::to_vec(self)?)?;
        ops::all(std::slice::from_ref(&draft), |_| ops::sync_file(&draft))?;
        ops::rename(&draft, &path)?;
        ops::sync_folder(stage)
    }

    pub(super) fn apply(&self, root: &Path, stage: &Path) -> io::Result<()> {
        self.units.iter().try_for_each(|unit| unit.apply(root, stage))
    }
}

impl UnitJournal {
    fn apply(&self, root: &Path, stage: &Path) -> io::Result<()> {
        let (target, staged) = (root.join(&self.folder), stage.join(&self.staged));
        if let Some(identity) = &self.exchange
            && (identity.is_of(&target) || (self.is_whole(&staged) && swap::swap(&staged, &target)?))
        {
            return swap::rescue(&staged, &target, self);
        }
        // The manifest is the last one to be moved.
        if !staged.join(MANIFEST).exists() {
            return Ok(());
        }
        ops::create_folder(&target)?;
        for name in &self.files {
            move_file(&staged.join(name), &target.join(name))?;
        }
        self.remove_stale(&target)?;
        self.sync(&target)?;
        move_file(&staged.join(MANIFEST), &target.join(MANIFEST))?;
        ops::sync_folder(&target)
    }

    /// True if no file of a staged folder has been moved.
    fn is_whole(&self, staged: &Path) -> bool {
        staged.join(MANIFEST).exists() && self.files.iter().all(|name| staged.join(name).exists())
    }

    /// Removes the files of the former generation. A file that was changed since belongs to the user.
    fn remove_stale(&self, target: &Path) -> io::Result<()> {
        for path in self.stale.iter().filter_map(|(name, hash)| unchanged(target, name, hash)) {
            ops::remove_file(&path)?;
            if let Some(folder) = path.parent().filter(|folder| *folder != target) {
                // A folder with other files stays.
                let _ = std::fs::remove_dir(folder);
            }
        }
        Ok(())
    }

    /// True if a file of the old folder is part of one of the two generations.
    pub(super) fn is_of_generations(&self, folder: &Path, name: &str) -> bool {
        let is_stale = self.stale.get(name).is_some_and(|hash| unchanged(folder, name, hash).is_some());
        is_stale || name == MANIFEST || self.files.iter().any(|file| file == name)
    }

    fn sync(&self, target: &Path) -> io::Result<()> {
        let mut folders: Vec<PathBuf> =
            self.files.iter().filter_map(|name| Some(target.join(name).parent()?.to_owned())).collect();
        folders.dedup();
        folders.iter().try_for_each(|folder| ops::sync_folder(folder))
    }
}

/// Returns the path of a file in a folder if it has a hash.
fn unchanged(folder: &Path, name: &str, hash: &str) -> Option<PathBuf> {
    let path = folder.join(name);
    let bytes = std::fs::metadata(&path).ok()?.len();
    let stored = StoredFile { bytes, sha256: hash.to_owned(), written_by: String::new() };
    stored.is_at(&path).ok()?.then_some(path)
}

/// Moves a file, also to another file system. A file that is not there was moved before.
fn move_file(from: &Path, to: &Path) -> io::Result<()> {
    if !from.exists() {
        return Ok(());
    }
    let folder = to.parent().unwrap_or(Path::new("."));
    if !folder.is_dir() {
        ops::create_folder(folder)?;
    }
    match ops::rename(from, to) {
        Err(error) if error.kind() == io::ErrorKind::CrossesDevices => {
            let copy = folder.join(copy_name(&to.to_string_lossy()));
            std::fs::copy(from, &copy)?;
            ops::sync_file(&copy)?;
            ops::rename(&copy, to)?;
            ops::remove_file(from)
        }
        other => other,
    }
}
