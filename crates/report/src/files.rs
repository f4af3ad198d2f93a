//! Single files, each with its old or its new content, and temporary names.

use std::fs::File;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use thiserror::Error;

const TEMPORARY: &str = ".trocar-";

#[derive(Debug, Error)]
pub enum OutputError {
    /// The former files are unchanged.
    #[error("cannot write {path}: {source}; choose another folder", path = path.display())]
    Write {
        /// The path.
        path: PathBuf,
        /// The cause.
        source: io::Error,
    },
}

/// A command that removes leftovers at this moment can disturb an attempt.
const ATTEMPTS: usize = 3;

/// Writes a file under a temporary name and renames it, so a reader finds the old or the new content, also after a loss
/// of power.
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
    let prefix = temporary_prefix();
    builder.prefix(&prefix);
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(std::fs::Permissions::from_mode(0o666));
    }
    let mut file = builder.tempfile_in(folder)?;
    // The lock marks the file as one of a living process.
    let _ = file.as_file().try_lock();
    file.write_all(content)?;
    file.as_file().sync_all()?;
    file.persist(path).map_err(|error| error.error)?;
    Ok(())
}

/// `tempfile` adds six characters.
pub(crate) fn temporary_prefix() -> String {
    format!("{TEMPORARY}{}-", std::process::id())
}

fn is_temporary(name: &str) -> bool {
    let parts = name.strip_prefix(TEMPORARY).and_then(|rest| rest.split_once('-'));
    parts.is_some_and(|(process, random)| process.parse::<u32>().is_ok() && random.len() == 6)
}

pub(crate) fn temporaries(folder: &Path) -> impl Iterator<Item = PathBuf> + use<> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    entries.filter(|entry| is_temporary(&entry.file_name().to_string_lossy())).map(|entry| entry.path())
}

/// Removes those of killed processes.
pub(crate) fn remove_left_files(folder: &Path) {
    let is_left = |path: &PathBuf| File::options().write(true).open(path).is_ok_and(|file| file.try_lock().is_ok());
    for path in temporaries(folder).filter(|path| !path.is_dir() && is_left(path)) {
        let _ = std::fs::remove_file(path);
    }
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
        for name in [".trocar-12-Ab3xyz", ".trocar-13-work01", ".trocarrc", ".trocar-backup"] {
            std::fs::write(named(name), b"left").expect("written");
        }
        let at_work = std::fs::File::open(named(".trocar-13-work01")).expect("there");
        at_work.try_lock().expect("locked");
        write_file(&named("x.csv"), b"one").expect("written");
        assert!(!named(".trocar-12-Ab3xyz").exists());
        for name in [".trocar-13-work01", ".trocarrc", ".trocar-backup", "x.csv"] {
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
