//! Writing files so that none is ever half there.

use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

use thiserror::Error;

/// How the temporary names begin.
const TEMPORARY: &str = ".trocar-";

/// A file or folder that cannot be written.
#[derive(Debug, Error)]
#[error("{path} cannot be written: {source}; give another place", path = path.display())]
pub struct OutputError {
    /// What was to be written.
    pub path: PathBuf,
    /// Why it was not.
    pub source: std::io::Error,
}

/// Writes a file to a temporary name beside it, then renames: what is there is either the old or the new, whole.
///
/// # Errors
/// [`OutputError`] with the path.
pub fn write_file(path: &Path, content: &[u8]) -> Result<(), OutputError> {
    stream_file(path, |file| file.write_all(content))
}

/// [`write_file`] for content that is written piece by piece and need not fit into memory.
///
/// # Errors
/// [`OutputError`] with the path.
pub fn stream_file(
    path: &Path,
    content: impl FnOnce(&mut (dyn Write + Send)) -> std::io::Result<()>,
) -> Result<(), OutputError> {
    let failed = |source| OutputError { path: path.to_owned(), source };
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    std::fs::create_dir_all(folder).map_err(failed)?;
    let mut builder = tempfile::Builder::new();
    builder.prefix(TEMPORARY);
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(std::fs::Permissions::from_mode(0o666));
    }
    let file = builder.tempfile_in(folder).map_err(failed)?;
    let mut buffered = BufWriter::with_capacity(1 << 18, file);
    content(&mut buffered).map_err(failed)?;
    let file = buffered.into_inner().map_err(|error| failed(error.into_error()))?;
    file.persist(path).map_err(|error| failed(error.error))?;
    Ok(())
}

/// A folder that files are written into.
#[derive(Debug, Clone)]
pub struct Folder(PathBuf);

impl Folder {
    /// The folder at a path; it is made when the first file is written.
    #[must_use]
    pub fn new(path: impl Into<PathBuf>) -> Self {
        Self(path.into())
    }

    /// A folder within this one.
    #[must_use]
    pub fn folder(&self, name: &str) -> Self {
        Self(self.0.join(name))
    }

    /// Its path.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.0
    }

    /// Removes what a program that was killed while it wrote has left under temporary names. Whoever else writes into the folder
    /// at that moment is told that the file cannot be written.
    pub fn remove_leftovers(&self) {
        for entry in std::fs::read_dir(&self.0).into_iter().flatten().flatten() {
            if entry.file_name().to_string_lossy().starts_with(TEMPORARY) {
                // It is of no use and does no harm.
                let _ = std::fs::remove_file(entry.path());
            }
        }
    }

    /// Writes a file into it.
    ///
    /// # Errors
    /// As [`write_file`].
    pub fn write(&self, name: &str, content: &[u8]) -> Result<(), OutputError> {
        write_file(&self.0.join(name), content)
    }

    /// Writes a file into it piece by piece.
    ///
    /// # Errors
    /// As [`write_file`].
    pub fn stream(
        &self,
        name: &str,
        content: impl FnOnce(&mut (dyn Write + Send)) -> std::io::Result<()>,
    ) -> Result<(), OutputError> {
        stream_file(&self.0.join(name), content)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_replaced_whole_and_nothing_else_is_left() {
        let folder = tempfile::tempdir().expect("a folder");
        let deep = Folder::new(folder.path()).folder("a").folder("b");
        deep.write("x.csv", b"one").expect("written");
        deep.write("x.csv", b"two").expect("written");
        assert_eq!(std::fs::read(deep.path().join("x.csv")).expect("there"), b"two");
        assert_eq!(std::fs::read_dir(deep.path()).expect("there").count(), 1);
    }

    #[test]
    fn what_a_killed_writer_has_left_is_removed_and_nothing_else() {
        let folder = tempfile::tempdir().expect("a folder");
        let folder = Folder::new(folder.path());
        folder.write("x.csv", b"one").expect("written");
        let (left, own) = (folder.path().join(".trocar-Ab3"), folder.path().join(".trocarrc"));
        std::fs::write(&left, b"ha").expect("written");
        std::fs::write(&own, b"mine").expect("written");
        folder.remove_leftovers();
        assert!(!left.exists() && own.exists() && folder.path().join("x.csv").exists());
        folder.folder("is not there").remove_leftovers();
    }

    #[test]
    fn a_place_that_is_no_folder_is_named() {
        let file = tempfile::NamedTempFile::new().expect("a file");
        let error = Folder::new(file.path()).write("x", b"").expect_err("not a folder");
        assert!(error.to_string().contains("another place"), "{error}");
    }
}
