//! The output folder of a command.

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use serde_json::{Map, Value as Json};
use sha2::{Digest, Sha256};

use super::draw::FigureStyle;
use super::generation::{Generation, StoredFile};
use super::{ColumnFormat, OutputError};
use trocar_base::hexadecimal::hexadecimal;

/// An output folder, the style of its figures, and the formats of its tables with one row per sample.
#[derive(Debug, Clone)]
pub struct Destination {
    /// The path.
    pub path: PathBuf,
    /// The style of the figures.
    pub figures: FigureStyle,
    /// The formats of tables with one row per sample.
    pub samples: Vec<ColumnFormat>,
}

impl Destination {
    /// The folder at a path, with figures of the default style and samples as CSV.
    #[must_use]
    pub fn new(path: impl Into<PathBuf>) -> Self {
        Self { path: path.into(), figures: FigureStyle::default(), samples: vec![ColumnFormat::Csv] }
    }

    /// Begins a generation of files of a command ([`Folder::commit`]). `folders` are the folders that will be written,
    /// relative to this one, with `""` for this one itself; another command that writes one of them is excluded.
    ///
    /// # Errors
    /// [`OutputError`], for example if another command writes one of the folders.
    pub fn open(&self, command: &'static str, folders: &[&str]) -> Result<Folder, OutputError> {
        let Self { path, figures, samples } = self.clone();
        let generation = Generation::begin(&path, command, folders)?;
        Ok(Folder { path, figures, samples, unit: String::new(), command, generation: Arc::new(generation) })
    }
}

/// A folder that a command writes. The files get their names by [`commit`](Self::commit), all at once; without it, no
/// file is written.
#[derive(Debug, Clone)]
pub struct Folder {
    /// The path.
    pub path: PathBuf,
    /// The style of the figures.
    pub figures: FigureStyle,
    /// The formats of tables with one row per sample.
    pub samples: Vec<ColumnFormat>,
    /// The path within the output folder.
    unit: String,
    command: &'static str,
    generation: Arc<Generation>,
}

impl Folder {
    /// A folder within this one, of the same generation.
    #[must_use]
    pub fn folder(&self, name: &str) -> Self {
        let unit = if self.unit.is_empty() { name.to_owned() } else { format!("{}/{name}", self.unit) };
        Self { path: self.path.join(name), unit, ..self.clone() }
    }

    /// This folder with files as another command writes them. They replace the files of that command.
    #[must_use]
    pub fn by(&self, command: &'static str) -> Self {
        Self { command, ..self.clone() }
    }

    /// This folder with other formats of tables with one row per sample.
    #[must_use]
    pub fn with_samples(&self, samples: Vec<ColumnFormat>) -> Self {
        Self { samples, ..self.clone() }
    }

    /// Adds a file.
    ///
    /// # Errors
    /// [`OutputError`].
    pub fn write(&self, name: &str, content: &[u8]) -> Result<(), OutputError> {
        self.stream(name, |file| file.write_all(content))
    }

    /// Adds a file in pieces.
    ///
    /// # Errors
    /// [`OutputError`].
    pub fn stream(
        &self,
        name: &str,
        content: impl FnOnce(&mut (dyn Write + Send)) -> io::Result<()>,
    ) -> Result<(), OutputError> {
        let staged = self.generation.staged(&self.unit, self.command, name)?;
        let stored = self.store(&staged, content);
        let stored = stored.map_err(|source| OutputError::Write { path: self.path.join(name), source })?;
        self.generation.add(&self.unit, name, stored);
        Ok(())
    }

    fn store(
        &self,
        path: &Path,
        content: impl FnOnce(&mut (dyn Write + Send)) -> io::Result<()>,
    ) -> io::Result<StoredFile> {
        let file = Hashed { file: File::create(path)?, hash: Sha256::new(), bytes: 0 };
        let mut buffered = BufWriter::with_capacity(1 << 18, file);
        content(&mut buffered)?;
        let Hashed { hash, bytes, .. } = buffered.into_inner().map_err(io::IntoInnerError::into_error)?;
        Ok(StoredFile { bytes, sha256: hexadecimal(&hash.finalize()), written_by: self.command.to_owned() })
    }

    /// Removes the added files. The former ones stay.
    pub fn discard(&self) {
        self.generation.discard(&self.unit);
    }

    /// Sets fields of the manifest besides the list of files.
    pub fn describe(&self, details: Map<String, Json>) {
        self.generation.describe(&self.unit, details);
    }

    /// Replaces the former files of the command by the added ones, in all folders of the generation.
    ///
    /// # Errors
    /// [`OutputError`]. Except for [`OutputError::Unfinished`], nothing has changed.
    pub fn commit(&self) -> Result<(), OutputError> {
        self.generation.commit()
    }
}

/// Computes the hash of a file while it is written.
struct Hashed {
    file: File,
    hash: Sha256,
    bytes: u64,
}

impl Write for Hashed {
    fn write(&mut self, content: &[u8]) -> io::Result<usize> {
        let written = self.file.write(content)?;
        self.hash.update(&content[..written]);
        self.bytes += written as u64;
        Ok(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}
