//! An unpacked unit.

use std::fs::{self, File};
use std::io::Read as _;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;
use std::sync::{Arc, Mutex, OnceLock, PoisonError, Weak};
use std::time::SystemTime;

use sha2::{Digest, Sha256};
use tempfile::TempDir;

use crate::container::unpack;
use crate::description::Description;
use crate::error::FmuError;
use crate::library::LoadedLibrary;

const MAX_BYTES: u64 = 1 << 30;
const MAX_DESCRIPTION_BYTES: u64 = 64 << 20;

/// A unit, unpacked to a temporary folder that is removed when it is dropped.
#[derive(Debug)]
pub struct Fmu {
    path: PathBuf,
    sha256: [u8; 32],
    description: Description,
    library_path: PathBuf,
    // Dropped before the folder that contains it.
    library: OnceLock<LoadedLibrary>,
    loading: Mutex<()>,
    /// True while a unit that allows only one instance has it.
    pub(crate) is_taken: AtomicBool,
    folder: TempDir,
}

impl Fmu {
    /// Unpacks a unit and reads its description. Executes no part of it.
    ///
    /// # Errors
    /// [`FmuError`] if the file is not a unit for co-simulation in FMI 2.0 or 3.0 with a library for this machine.
    pub fn open(path: &Path) -> Result<Self, FmuError> {
        let content = read(path, MAX_BYTES)?;
        let folder = tempfile::Builder::new().prefix("fmu-").tempdir();
        let folder = folder.map_err(|error| FmuError::Unpack(error.to_string()))?;
        unpack(&content, folder.path())?;
        let xml = folder.path().join("modelDescription.xml");
        if !xml.is_file() {
            return Err(FmuError::NoDescription);
        }
        let text = String::from_utf8(read(&xml, MAX_DESCRIPTION_BYTES)?);
        let text = text.map_err(|_| FmuError::Description("is not UTF-8".into()))?;
        let description = Description::parse(text.trim_start_matches('\u{feff}'))?;
        // Create the folder also for units without resources, because they receive its path.
        fs::create_dir_all(folder.path().join("resources")).map_err(|error| FmuError::Unpack(error.to_string()))?;
        let library_path = library_path(folder.path(), &description)?;
        let sha256 = Sha256::digest(&content).into();
        Ok(Self {
            path: path.to_owned(),
            sha256,
            description,
            library_path,
            library: OnceLock::new(),
            loading: Mutex::default(),
            is_taken: AtomicBool::new(false),
            folder,
        })
    }

    /// Like [`Fmu::open`], but shares the unpacked unit while it is in use: the same unchanged file gives the same
    /// unit.
    ///
    /// # Errors
    /// The errors of [`Fmu::open`].
    pub fn open_shared(path: &Path) -> Result<Arc<Self>, FmuError> {
        type Identity = (PathBuf, u64, Option<SystemTime>);
        static OPEN: Mutex<Vec<(Identity, Weak<Fmu>)>> = Mutex::new(vec![]);
        let metadata = fs::metadata(path).map_err(|error| FmuError::File(error.to_string()))?;
        let path = fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
        let identity = (path, metadata.len(), metadata.modified().ok());
        let mut open = OPEN.lock().unwrap_or_else(PoisonError::into_inner);
        open.retain(|(_, unit)| unit.strong_count() > 0);
        let same = open.iter().find(|(known, _)| *known == identity).and_then(|(_, unit)| unit.upgrade());
        if let Some(unit) = same {
            return Ok(unit);
        }
        let unit = Arc::new(Self::open(&identity.0)?);
        open.push((identity, Arc::downgrade(&unit)));
        Ok(unit)
    }

    /// The file.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The SHA-256 of the file.
    #[must_use]
    pub fn sha256(&self) -> [u8; 32] {
        self.sha256
    }

    /// The description.
    #[must_use]
    pub fn description(&self) -> &Description {
        &self.description
    }

    /// Loads the library unless it is loaded. This executes third-party code.
    ///
    /// # Errors
    /// [`FmuError::Library`], [`FmuError::NoFunction`].
    pub fn load(&self) -> Result<(), FmuError> {
        self.library().map(drop)
    }

    pub(crate) fn library(&self) -> Result<&LoadedLibrary, FmuError> {
        if let Some(library) = self.library.get() {
            return Ok(library);
        }
        // Only one thread loads it.
        let _loading = self.loading.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(library) = self.library.get() {
            return Ok(library);
        }
        let library = LoadedLibrary::load(&self.library_path, (self.description.version, self.description.needs_tool))?;
        Ok(self.library.get_or_init(|| library))
    }

    pub(crate) fn resources(&self) -> PathBuf {
        self.folder.path().join("resources")
    }
}

fn read(path: &Path, max: u64) -> Result<Vec<u8>, FmuError> {
    let cannot = |error: std::io::Error| FmuError::File(error.to_string());
    let metadata = fs::metadata(path).map_err(cannot)?;
    if !metadata.is_file() {
        return Err(FmuError::File("it is not a file".into()));
    }
    let mut bytes = vec![];
    File::open(path).map_err(cannot)?.take(max + 1).read_to_end(&mut bytes).map_err(cannot)?;
    if bytes.len() as u64 > max {
        return Err(FmuError::Size { max, unit: "bytes" });
    }
    Ok(bytes)
}

fn library_path(folder: &Path, description: &Description) -> Result<PathBuf, FmuError> {
    let file = format!("{}.{}", description.identifier, std::env::consts::DLL_EXTENSION);
    let platform = description.version.platform();
    let path = folder.join("binaries").join(&platform).join(&file);
    if path.is_file() {
        return Ok(path);
    }
    let listed = fs::read_dir(folder.join("binaries"));
    let names = listed.into_iter().flatten().flatten().map(|entry| entry.file_name().to_string_lossy().into_owned());
    let mut has: Vec<String> = names.collect();
    has.sort();
    Err(FmuError::NoPlatform { wanted: format!("binaries/{platform}/{file}"), has })
}
