//! Locks of the operating system, which end with their process.

use std::fs::{File, TryLockError};
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use super::{LOCK, OutputError};

const ROOT_LOCK: &str = ".trocar-lock";

/// Maximum time that a command waits for another one to finish its moves.
const WAIT: Duration = Duration::from_secs(60);

/// Excludes other commands from the stages of an output folder, for milliseconds.
#[derive(Debug)]
pub(super) struct Exclusive {
    path: PathBuf,
    _file: File,
}

/// Waits for the lock of an output folder.
///
/// # Errors
/// [`OutputError::Write`] if the folder is not writable; [`OutputError::Busy`] after a minute.
pub(super) fn exclusive(root: &Path) -> Result<Exclusive, OutputError> {
    let path = root.join(ROOT_LOCK);
    let failed = |source| OutputError::Write { path: root.to_owned(), source };
    let begin = Instant::now();
    loop {
        let file = match File::options().write(true).create(true).truncate(false).open(&path) {
            // Another command has removed the folder that it had created.
            Err(error) if error.kind() == ErrorKind::NotFound && begin.elapsed() < WAIT => {
                std::fs::create_dir_all(root).map_err(failed)?;
                continue;
            }
            file => file.map_err(failed)?,
        };
        match file.try_lock() {
            // The former owner removes the file, so a lock of a removed file excludes nobody.
            Ok(()) if !is_at(&file, &path) => {}
            // File systems without locks are not protected.
            Ok(()) | Err(TryLockError::Error(_)) => return Ok(Exclusive { path, _file: file }),
            Err(TryLockError::WouldBlock) if begin.elapsed() > WAIT => {
                return Err(OutputError::Busy { path: root.to_owned() });
            }
            Err(TryLockError::WouldBlock) => std::thread::sleep(Duration::from_millis(2)),
        }
    }
}

/// True if there is a lock, of a command at work or of a killed one.
pub(super) fn is_left_at(root: &Path) -> bool {
    root.join(ROOT_LOCK).exists()
}

impl Drop for Exclusive {
    fn drop(&mut self) {
        // The next owner removes a file that stays.
        let _ = std::fs::remove_file(&self.path);
    }
}

/// True if a path leads to an open file.
#[cfg(unix)]
fn is_at(file: &File, path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt as _;
    let same = |one: std::fs::Metadata, other: std::fs::Metadata| (one.dev(), one.ino()) == (other.dev(), other.ino());
    file.metadata().is_ok_and(|open| std::fs::metadata(path).is_ok_and(|there| same(open, there)))
}

/// Other systems do not remove the name of an open file.
#[cfg(not(unix))]
fn is_at(_file: &File, _path: &Path) -> bool {
    true
}

/// The process of a stage.
pub(super) enum Owner {
    Alive,
    /// The file system has no locks.
    Unknown,
    /// The process has ended. The lock excludes others from the recovery.
    Ended(Option<File>),
}

pub(super) fn owner(stage: &Path) -> Owner {
    let Ok(file) = File::options().write(true).open(stage.join(LOCK)) else { return Owner::Ended(None) };
    match file.try_lock() {
        Ok(()) => Owner::Ended(Some(file)),
        Err(TryLockError::WouldBlock) => Owner::Alive,
        Err(TryLockError::Error(_)) => Owner::Unknown,
    }
}

/// True if a temporary file belongs to a process that has ended.
pub(super) fn is_left(file: &Path) -> bool {
    File::options().write(true).open(file).is_ok_and(|file| file.try_lock().is_ok())
}
