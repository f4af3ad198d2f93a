//! Writes files atomically: a reader finds either the old or the new content.

use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

use thiserror::Error;

use super::ColumnFormat;
use super::draw::FigureStyle;

const TEMPORARY: &str = ".trocar-";

/// An error of writing a file or folder.
#[derive(Debug, Error)]
#[error("cannot write {path}: {source}; choose another folder", path = path.display())]
pub struct OutputError {
    /// The path.
    pub path: PathBuf,
    /// The cause.
    pub source: std::io::Error,
}

/// Writes a file under a temporary name in the same folder, then renames it: it always has its old or its new content.
///
/// # Errors
/// [`OutputError`] with the path.
pub fn write_file(path: &Path, content: &[u8]) -> Result<(), OutputError> {
    stream_file(path, |file| file.write_all(content))
}

/// Like [`write_file`], for content produced in pieces.
fn stream_file(
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

/// An output folder, the style of its figures, and the formats of its tables with one row per sample.
#[derive(Debug, Clone)]
pub struct Folder {
    /// The path. The first written file creates it.
    pub path: PathBuf,
    /// The style of the figures.
    pub figures: FigureStyle,
    /// The formats of tables with one row per sample.
    pub samples: Vec<ColumnFormat>,
}

impl Folder {
    /// The folder at a path, with figures of the default style and samples as CSV.
    #[must_use]
    pub fn new(path: impl Into<PathBuf>) -> Self {
        Self { path: path.into(), figures: FigureStyle::default(), samples: vec![ColumnFormat::Csv] }
    }

    /// A folder within this one.
    #[must_use]
    pub fn folder(&self, name: &str) -> Self {
        Self { path: self.path.join(name), ..self.clone() }
    }

    /// Removes temporary files of a killed process. A write of another process at the same time fails.
    pub fn remove_leftovers(&self) {
        for entry in std::fs::read_dir(&self.path).into_iter().flatten().flatten() {
            if entry.file_name().to_string_lossy().starts_with(TEMPORARY) {
                // A leftover file is harmless.
                let _ = std::fs::remove_file(entry.path());
            }
        }
    }

    /// Writes a file into the folder.
    ///
    /// # Errors
    /// The errors of [`write_file`].
    pub fn write(&self, name: &str, content: &[u8]) -> Result<(), OutputError> {
        write_file(&self.path.join(name), content)
    }

    /// Writes a file into the folder in pieces.
    ///
    /// # Errors
    /// The errors of [`write_file`].
    pub fn stream(
        &self,
        name: &str,
        content: impl FnOnce(&mut (dyn Write + Send)) -> std::io::Result<()>,
    ) -> Result<(), OutputError> {
        stream_file(&self.path.join(name), content)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_replaced_and_no_temporary_file_remains() {
        let folder = tempfile::tempdir().expect("a folder");
        let deep = Folder::new(folder.path()).folder("a").folder("b");
        deep.write("x.csv", b"one").expect("written");
        deep.write("x.csv", b"two").expect("written");
        assert_eq!(std::fs::read(deep.path.join("x.csv")).expect("there"), b"two");
        assert_eq!(std::fs::read_dir(deep.path).expect("there").count(), 1);
    }

    #[test]
    fn only_the_leftovers_of_a_killed_process_are_removed() {
        let folder = tempfile::tempdir().expect("a folder");
        let folder = Folder::new(folder.path());
        folder.write("x.csv", b"one").expect("written");
        let (left, own) = (folder.path.join(".trocar-Ab3"), folder.path.join(".trocarrc"));
        std::fs::write(&left, b"left").expect("written");
        std::fs::write(&own, b"own").expect("written");
        folder.remove_leftovers();
        assert!(!left.exists() && own.exists() && folder.path.join("x.csv").exists());
        folder.folder("is not there").remove_leftovers();
    }

    #[test]
    fn a_path_that_is_not_a_folder_is_an_error() {
        let file = tempfile::NamedTempFile::new().expect("a file");
        let error = Folder::new(file.path()).write("x", b"").expect_err("not a folder");
        assert!(error.to_string().contains("another folder"), "{error}");
    }
}
