//! Replaces a folder in one step.

use std::io;
use std::path::Path;

use serde::{Deserialize, Serialize};

use super::journal::UnitJournal;
use super::{ops, recovery};

/// The identity of a folder, which it keeps when it is renamed.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct Identity {
    device: u64,
    number: u64,
}

impl Identity {
    /// Returns the identity of a folder; `None` on a system that cannot exchange folders.
    #[cfg(unix)]
    pub(super) fn of(folder: &Path) -> Option<Self> {
        use std::os::unix::fs::MetadataExt as _;
        let about = std::fs::symlink_metadata(folder).ok()?;
        Some(Self { device: about.dev(), number: about.ino() })
    }

    #[cfg(not(unix))]
    pub(super) fn of(_folder: &Path) -> Option<Self> {
        None
    }

    pub(super) fn is_of(&self, folder: &Path) -> bool {
        Self::of(folder).as_ref() == Some(self)
    }
}

/// Gives a staged folder the name of its target. The staged path then has the old folder, if there was one. Returns
/// false if the file system cannot exchange folders.
pub(super) fn swap(staged: &Path, target: &Path) -> io::Result<bool> {
    let parent = target.parent().unwrap_or(Path::new("."));
    ops::create_folder(parent)?;
    let is_there = std::fs::symlink_metadata(target).is_ok();
    let swapped = if is_there { ops::exchange(staged, target) } else { ops::rename(staged, target) };
    match swapped {
        Ok(()) => ops::sync_folder(parent).map(|()| true),
        Err(error) if ops::is_crashed() => Err(error),
        // A cause that moves of single files do not mend appears again with them.
        Err(_) => Ok(false),
    }
}

/// Moves the files of others that arrived in the old folder during the exchange into the new one.
pub(super) fn rescue(old: &Path, target: &Path, journal: &UnitJournal) -> io::Result<()> {
    for entry in std::fs::read_dir(old).into_iter().flatten() {
        let entry = entry?;
        let name = entry.file_name();
        let text = name.to_string_lossy();
        let is_known = journal.is_of_generations(old, &text) || recovery::is_temporary(&text);
        if !is_known && std::fs::symlink_metadata(target.join(&name)).is_err() {
            ops::rename(&entry.path(), &target.join(&name))?;
        }
    }
    ops::sync_folder(target)
}
