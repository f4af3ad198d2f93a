//! Writes single files atomically: a reader finds either the old or the new content.

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use thiserror::Error;

use super::generation::{TEMPORARY, remove_left_files, sync_folder};

/// An error of writing a file or folder.
#[derive(Debug, Error)]
pub enum OutputError {
    /// A file cannot be written. The former files are unchanged.
    #[error("cannot write {path}: {source}; choose another folder", path = path.display())]
    Write {
        /// The path.
        path: PathBuf,
        /// The cause.
        source: io::Error,
    },
    /// Another process writes the same folder.
    #[error("{path} is being written by another process; wait for it or end it, or give another --out", path = path.display())]
    Busy {
        /// The folder.
        path: PathBuf,
    },
    /// The new files are complete, but not all of them have their names.
    #[error(
        "cannot move all files out of {stage}: {source}; remove the cause, then the next command with this --out \
         continues",
        stage = stage.display()
    )]
    Unfinished {
        /// The folder with the files.
        stage: PathBuf,
        /// The cause.
        source: io::Error,
    },
}

/// Number of attempts to write a file. A command that removes leftovers at this moment can disturb one.
const ATTEMPTS: usize = 3;

/// Writes a file under a temporary name in the same folder, then renames it: it always has its old or its new content,
/// also after a loss of power. Removes the temporary files of killed processes.
///
/// # Errors
/// [`OutputError`] with the path.
pub fn write_file(path: &Path, content: &[u8]) -> Result<(), OutputError> {
    let failed = |source| OutputError::Write { path: path.to_owned(), source };
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    std::fs::create_dir_all(folder).map_err(failed)?;
    remove_left_files(folder);
    let mut written = Ok(());
    for _ in 0..ATTEMPTS {
        written = attempt(folder, path, content);
        if !written.as_ref().is_err_and(|error| error.kind() == io::ErrorKind::NotFound) {
            break;
        }
    }
    written.map_err(failed)
}

fn attempt(folder: &Path, path: &Path, content: &[u8]) -> io::Result<()> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(TEMPORARY);
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(std::fs::Permissions::from_mode(0o666));
    }
    let mut file = builder.tempfile_in(folder)?;
    // Marks the file as one of a process that works. File systems without locks are not protected.
    let _ = file.as_file().try_lock();
    file.write_all(content)?;
    file.as_file().sync_all()?;
    file.persist(path).map_err(|error| error.error)?;
    sync_folder(folder)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_replaced_and_no_temporary_file_remains() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a").join("b").join("x.csv");
        write_file(&path, b"one").expect("written");
        write_file(&path, b"two").expect("written");
        assert_eq!(std::fs::read(&path).expect("there"), b"two");
        assert_eq!(std::fs::read_dir(path.parent().expect("a folder")).expect("there").count(), 1);
    }

    #[test]
    fn only_the_leftovers_of_a_killed_process_are_removed() {
        let folder = tempfile::tempdir().expect("a folder");
        let named = |name: &str| folder.path().join(name);
        for name in [".trocar-Ab3xyz", ".trocar-work01", ".trocarrc", ".trocar-notes"] {
            std::fs::write(named(name), b"left").expect("written");
        }
        let at_work = std::fs::File::open(named(".trocar-work01")).expect("there");
        at_work.try_lock().expect("locked");
        write_file(&named("x.csv"), b"one").expect("written");
        assert!(!named(".trocar-Ab3xyz").exists());
        for name in [".trocar-work01", ".trocarrc", ".trocar-notes", "x.csv"] {
            assert!(named(name).exists(), "{name}");
        }
    }

    #[test]
    fn a_path_that_is_not_a_folder_is_an_error() {
        let file = tempfile::NamedTempFile::new().expect("a file");
        let error = write_file(&file.path().join("x"), b"").expect_err("not a folder");
        assert!(error.to_string().contains("another folder"), "{error}");
    }
}
