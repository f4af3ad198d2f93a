//! Later changes of the files do not change the scenario.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use trocar_recording::{Columns, Limits, Recording};

/// Clones share the content.
///
/// Not part of the identity of a [`Source`](super::Source).
#[derive(Debug, Clone, Default)]
pub struct KeptFiles(Arc<Mutex<FileContents>>);

#[derive(Debug, Clone, Default)]
pub struct FileContents {
    /// At the time of its first use.
    pub canonical: BTreeMap<PathBuf, PathBuf>,
    pub bytes: BTreeMap<PathBuf, Arc<[u8]>>,
    /// By canonical path and settings for reading.
    pub recordings: BTreeMap<(PathBuf, String), Arc<Recording>>,
}

impl KeptFiles {
    pub fn of(content: FileContents) -> Self {
        Self(Arc::new(Mutex::new(content)))
    }

    /// A copy of the content read so far.
    pub fn content(&self) -> FileContents {
        self.locked().clone()
    }

    pub(super) fn canonical(&self, path: &Path) -> PathBuf {
        self.locked().canonical.entry(path.to_owned()).or_insert_with(|| canonical_path(path)).clone()
    }

    pub(super) fn bytes<E>(&self, path: &Path, read: impl FnOnce() -> Result<Vec<u8>, E>) -> Result<Arc<[u8]>, E> {
        if let Some(kept) = self.locked().bytes.get(path) {
            return Ok(kept.clone());
        }
        let bytes: Arc<[u8]> = read()?.into();
        self.locked().bytes.insert(path.to_owned(), bytes.clone());
        Ok(bytes)
    }

    pub(super) fn recording<E>(
        &self,
        (path, columns, limits): (&Path, &Columns, &Limits),
        read: impl FnOnce() -> Result<Recording, E>,
    ) -> Result<Recording, E> {
        let key = (path.to_owned(), format!("{columns:?} {limits:?}"));
        if let Some(kept) = self.locked().recordings.get(&key) {
            return Ok(Recording::clone(kept));
        }
        let recording = read()?;
        self.locked().recordings.insert(key, Arc::new(recording.clone()));
        Ok(recording)
    }

    fn locked(&self) -> MutexGuard<'_, FileContents> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

pub(super) fn canonical_path(path: &Path) -> PathBuf {
    std::fs::canonicalize(path).unwrap_or_else(|_| path.to_owned())
}

impl PartialEq for KeptFiles {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

impl Eq for KeptFiles {}

#[cfg(test)]
mod tests {
    use super::super::{Scenario, Source};
    use super::*;

    #[test]
    fn a_scenario_is_loaded_again_from_its_kept_files() {
        let folder = tempfile::tempdir().expect("a folder");
        let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).expect("writes");
        write("base.toml", "base = \"builtin:paper/augmented\"\n[scaling]\nforce = 0.5\n");
        write("mine.toml", "base = \"base.toml\"\n");
        let source = Source::Disk(folder.path().join("mine.toml")).keeping(KeptFiles::default());
        let echo = |source: &Source| Scenario::load(source, &[]).map(|scenario| scenario.echo());
        let before = echo(&source).expect("good");
        let content = source.kept().expect("keeps").content();
        assert_eq!(content.bytes.len(), 2);
        write("base.toml", "base = \"builtin:paper/augmented\"\n[scaling]\nforce = 2.0\n");
        assert_eq!(echo(&source).as_ref(), Ok(&before));
        assert_ne!(echo(source.plain()).as_ref(), Ok(&before));
        folder.close().expect("closes");
        assert_eq!(echo(&source.plain().keeping(KeptFiles::of(content))).as_ref(), Ok(&before));
        assert!(echo(source.plain()).is_err());
    }
}
