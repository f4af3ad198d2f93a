//! The stages of this process, for Ctrl-C.

use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

use super::{Generation, recovery};

/// The stages, each with its output folder if this process created it.
static LIVE: Mutex<Vec<(PathBuf, Option<PathBuf>)>> = Mutex::new(vec![]);

/// Held by each commit.
static COMMIT: Mutex<()> = Mutex::new(());

fn live() -> MutexGuard<'static, Vec<(PathBuf, Option<PathBuf>)>> {
    LIVE.lock().unwrap_or_else(PoisonError::into_inner)
}

pub(super) fn add(generation: &Generation) {
    let root = generation.made_root.then(|| generation.root.clone());
    live().push((generation.stage.clone(), root));
}

pub(super) fn remove(stage: &Path) {
    live().retain(|(live, _)| live != stage);
}

/// Delays [`discard_all`].
pub(super) fn hold() -> MutexGuard<'static, ()> {
    COMMIT.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Removes everything that this process has written and not yet stored, before the process ends. A commit that has
/// begun is completed first. Returns true if something was removed.
pub fn discard_all() -> bool {
    let commit = hold();
    let is_any = !live().is_empty();
    for (stage, root) in live().drain(..) {
        // A file that another thread writes at this moment is removed at the second attempt; the next command removes
        // the rest.
        let _ = recovery::remove(&stage).or_else(|_| recovery::remove(&stage));
        if let Some(root) = root {
            let _ = std::fs::remove_dir(root);
        }
    }
    // No commit begins before the process ends.
    std::mem::forget(commit);
    is_any
}
