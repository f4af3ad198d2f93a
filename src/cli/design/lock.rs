//! The lock of a design's folder: two processes would replace each other's files.

use std::fs::{File, TryLockError};
use std::path::{Path, PathBuf};

use crate::cli::error::CliError;
use trocar_report::OutputError;

const LOCK: &str = "search.lock";

/// A lock that ends with the process.
pub(super) struct Lock {
    path: PathBuf,
    _file: File,
}

impl Lock {
    /// Creates the folder and locks it.
    pub(super) fn of(folder: &Path) -> Result<Self, CliError> {
        let path = folder.join(LOCK);
        let failed = |source| OutputError { path: path.clone(), source };
        std::fs::create_dir_all(folder).map_err(failed)?;
        let file = File::options().write(true).create(true).truncate(false).open(&path).map_err(failed)?;
        match file.try_lock() {
            Err(TryLockError::WouldBlock) => Err(CliError::BusyDesign { folder: folder.display().to_string() }),
            // File systems without locks, such as some network drives, are not protected.
            Ok(()) | Err(TryLockError::Error(_)) => Ok(Self { path, _file: file }),
        }
    }

    /// Removes the file of the lock.
    pub(super) fn remove(self) {
        // A leftover file is harmless.
        let _ = std::fs::remove_file(&self.path);
    }
}
