//! Completes or removes what a killed command has left.

use std::io;
use std::path::{Path, PathBuf};

use super::journal::Journal;
use super::lock::{self, Owner};
use super::{CLAIMS, OutputError, TEMPORARY, journal_path, ops};

/// Completes or removes the generations of killed commands in an output folder. Without leftovers, nothing is written.
///
/// # Errors
/// [`OutputError`] if a generation cannot be completed or the folder cannot be written.
pub fn recover(root: &Path) -> Result<(), OutputError> {
    if entries(root).next().is_none() && !lock::is_left_at(root) {
        return Ok(());
    }
    let _exclusive = lock::exclusive(root)?;
    recover_locked(root).map(drop)
}

/// Recovers while the lock of the folder is held. Returns the claims of commands that are at work.
pub(super) fn recover_locked(root: &Path) -> Result<Vec<String>, OutputError> {
    let mut claims = vec![];
    remove_left_files(root);
    for path in entries(root) {
        if !path.is_dir() {
            continue;
        }
        match lock::owner(&path) {
            Owner::Alive => claims.extend(claims_of(&path)),
            Owner::Unknown => {}
            Owner::Ended(_lock) => {
                let unfinished = |source| OutputError::Unfinished { stage: path.clone(), source };
                if let Some(journal) = Journal::read(&journal_path(&path)).map_err(unfinished)? {
                    journal.apply(root, &path).map_err(unfinished)?;
                }
                remove(&path).map_err(unfinished)?;
            }
        }
    }
    Ok(claims)
}

/// Removes the temporary files of killed processes from a folder.
pub(crate) fn remove_left_files(folder: &Path) {
    for path in entries(folder).filter(|path| !path.is_dir() && lock::is_left(path)) {
        // A leftover file is harmless.
        let _ = std::fs::remove_file(path);
    }
}

/// Returns the claims of the other commands that are at work in an output folder.
pub(super) fn claims(root: &Path, own: &Path) -> Vec<String> {
    let others = entries(root).filter(|path| path != own && path.is_dir());
    others.filter(|path| matches!(lock::owner(path), Owner::Alive)).flat_map(|path| claims_of(&path)).collect()
}

fn claims_of(stage: &Path) -> Vec<String> {
    let text = std::fs::read_to_string(stage.join(CLAIMS)).unwrap_or_default();
    serde_json::from_str(&text).unwrap_or_default()
}

/// Removes a stage: first its journal, so that a stage without a journal is never applied.
pub(super) fn remove(stage: &Path) -> io::Result<()> {
    match ops::remove_file(&journal_path(stage)) {
        Ok(()) => ops::sync_folder(stage)?,
        Err(error) if error.kind() == io::ErrorKind::NotFound => {}
        Err(error) => return Err(error),
    }
    ops::remove_all(stage)
}

/// Returns the temporary files and folders.
pub(crate) fn entries(root: &Path) -> impl Iterator<Item = PathBuf> + use<> {
    let entries = std::fs::read_dir(root).into_iter().flatten().flatten();
    entries.filter(|entry| is_temporary(&entry.file_name().to_string_lossy())).map(|entry| entry.path())
}

/// True for the prefix with six letters or digits.
pub(super) fn is_temporary(name: &str) -> bool {
    name.strip_prefix(TEMPORARY)
        .is_some_and(|rest| rest.len() == 6 && rest.bytes().all(|byte| byte.is_ascii_alphanumeric()))
}
