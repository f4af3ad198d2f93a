use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::PathBuf;
use std::sync::Arc;

use serde_json::{Map, Value as Json};

use super::draw::FigureStyle;
use super::stage::Stage;
use super::{ColumnFormat, OutputError};

/// The folder of `--out`.
#[derive(Debug, Clone)]
pub struct Destination {
    pub path: PathBuf,
    pub figures: FigureStyle,
    /// For tables with one row per sample.
    pub samples: Vec<ColumnFormat>,
}

impl Destination {
    /// Figures of the default style and samples as CSV.
    pub fn new(path: impl Into<PathBuf>) -> Self {
        Self { path: path.into(), figures: FigureStyle::default(), samples: vec![ColumnFormat::Csv] }
    }

    /// Begins the folder `name` of a command ([`Folder::commit`]).
    pub fn open(&self, command: &'static str, name: &str) -> Result<Folder, OutputError> {
        let Self { path, figures, samples } = self.clone();
        let stage = Arc::new(Stage::begin(&path, name)?);
        Ok(Folder { path: path.join(name), figures, samples, within: PathBuf::new(), command, stage })
    }
}

/// A folder that a command writes. [`commit`](Self::commit) replaces the old one as a whole; without it, no file is
/// written.
#[derive(Debug, Clone)]
pub struct Folder {
    pub path: PathBuf,
    pub figures: FigureStyle,
    /// For tables with one row per sample.
    pub samples: Vec<ColumnFormat>,
    /// The path within the folder of the command.
    within: PathBuf,
    command: &'static str,
    stage: Arc<Stage>,
}

impl Folder {
    /// A folder within this one.
    pub fn folder(&self, name: &str) -> Self {
        Self { path: self.path.join(name), within: self.within.join(name), ..self.clone() }
    }

    /// This folder with other formats of tables with one row per sample.
    pub fn with_samples(&self, samples: Vec<ColumnFormat>) -> Self {
        Self { samples, ..self.clone() }
    }

    pub fn write(&self, name: &str, content: &[u8]) -> Result<(), OutputError> {
        self.stream(name, |file| file.write_all(content))
    }

    /// Adds a file in pieces.
    pub fn stream(
        &self,
        name: &str,
        content: impl FnOnce(&mut (dyn Write + Send)) -> io::Result<()>,
    ) -> Result<(), OutputError> {
        let path = self.stage.new_folder().join(&self.within).join(name);
        let store = || -> io::Result<()> {
            fs::create_dir_all(path.parent().unwrap_or(&path))?;
            let mut file = BufWriter::with_capacity(1 << 18, File::create(&path)?);
            content(&mut file)?;
            file.flush()
        };
        store().map_err(|source| OutputError::Write { path: self.path.join(name), source })
    }

    /// Replaces the files that the command wrote before by the added ones. After an error, the old folder has not
    /// changed.
    pub fn commit(&self) -> Result<(), OutputError> {
        self.commit_with(Map::new())
    }

    /// With further fields of the manifest.
    pub fn commit_with(&self, details: Map<String, Json>) -> Result<(), OutputError> {
        self.stage.commit(self.command, details)
    }
}
