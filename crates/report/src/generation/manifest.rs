//! The manifest of a folder: the files that trocar has written into it, with their sizes and hashes.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, Read as _};
use std::path::Path;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value as Json};
use sha2::{Digest, Sha256};
use thiserror::Error;
use trocar_base::hexadecimal::hexadecimal;

/// The file name of a manifest.
pub const MANIFEST: &str = "manifest.json";

const VERSION: &str = "trocar_version";
const FOLDERS: &str = "folders";
const FILES: &str = "files";
const HASH: &str = "manifest_sha256";

/// A file, as it was written.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct StoredFile {
    /// Size in bytes.
    pub bytes: u64,
    /// SHA-256 of the content, in hexadecimal digits.
    pub sha256: String,
    /// The command that wrote the file.
    pub written_by: String,
}

/// The manifest of a folder.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Manifest {
    /// Fields of the command, and the version of the program that wrote the file.
    pub details: Map<String, Json>,
    /// The subfolders of a comparison or of many recordings, each with the command that wrote it.
    pub folders: BTreeMap<String, String>,
    /// The files by their path within the folder.
    pub files: BTreeMap<String, StoredFile>,
}

/// An error of reading a manifest.
#[derive(Debug, Error)]
pub enum ManifestError {
    /// The folder has no manifest.
    #[error("{folder} has no {MANIFEST}")]
    Missing {
        /// The folder.
        folder: String,
    },
    /// The manifest was changed or is not one.
    #[error("{folder}/{MANIFEST} is damaged: {reason}")]
    Damaged {
        /// The folder.
        folder: String,
        /// The cause.
        reason: String,
    },
}

/// A difference between a folder and its manifest.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Difference {
    /// A file or a subfolder is missing.
    Missing(String),
    /// A file has another size or another content.
    Changed(String),
    /// A file cannot be read.
    Unreadable(String, String),
}

impl std::fmt::Display for Difference {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Missing(name) => write!(f, "{name} is missing"),
            Self::Changed(name) => write!(f, "{name} was changed"),
            Self::Unreadable(name, reason) => write!(f, "{name} cannot be read: {reason}"),
        }
    }
}

/// Returns the SHA-256 of bytes in hexadecimal digits.
#[must_use]
pub fn sha256(content: &[u8]) -> String {
    hexadecimal(&Sha256::digest(content))
}

impl Manifest {
    /// Reads the manifest of a folder.
    ///
    /// # Errors
    /// [`ManifestError`].
    pub fn read(folder: &Path) -> Result<Self, ManifestError> {
        let named = || folder.display().to_string();
        match std::fs::read_to_string(folder.join(MANIFEST)) {
            Ok(text) => Self::parse(&text).map_err(|reason| ManifestError::Damaged { folder: named(), reason }),
            Err(error) if error.kind() == io::ErrorKind::NotFound => Err(ManifestError::Missing { folder: named() }),
            Err(error) => Err(ManifestError::Damaged { folder: named(), reason: error.to_string() }),
        }
    }

    fn parse(text: &str) -> Result<Self, String> {
        let mut fields: Map<String, Json> = serde_json::from_str(text).map_err(|error| error.to_string())?;
        let hash = fields.remove(HASH).and_then(|hash| Some(hash.as_str()?.to_owned()));
        let hash = hash.ok_or_else(|| format!("it has no {HASH}"))?;
        if hash.len() != 64 || sealed(&text.replacen(&hash, "", 1)) != hash {
            return Err(format!("its content does not have its {HASH}"));
        }
        let mut taken = |name: &str| fields.remove(name).unwrap_or_default();
        let folders = serde_json::from_value(taken(FOLDERS)).map_err(|error| error.to_string())?;
        let files = serde_json::from_value(taken(FILES)).map_err(|error| error.to_string())?;
        Ok(Self { details: fields, folders, files })
    }

    /// The text of the file. Its last field is the SHA-256 of the text with an empty string in this field.
    #[must_use]
    pub fn text(&self) -> String {
        let mut fields = Map::new();
        fields.insert(VERSION.into(), env!("CARGO_PKG_VERSION").into());
        fields.extend(self.details.clone().into_iter().filter(|(key, _)| key != VERSION));
        // Maps of names are always valid JSON.
        fields.insert(FOLDERS.into(), serde_json::to_value(&self.folders).unwrap_or_default());
        fields.insert(FILES.into(), serde_json::to_value(&self.files).unwrap_or_default());
        fields.insert(HASH.into(), "".into());
        let text = format!("{:#}\n", Json::Object(fields));
        let hash = sealed(&text);
        let empty = format!("\"{HASH}\": \"\"");
        match text.rfind(&empty) {
            Some(at) => format!("{}\"{HASH}\": \"{hash}\"{}", &text[..at], &text[at + empty.len()..]),
            None => text,
        }
    }

    /// Compares the folder with the manifest. Files that the manifest does not name do not matter.
    #[must_use]
    pub fn differences(&self, folder: &Path) -> Vec<Difference> {
        let of_file = |(name, stored): (&String, &StoredFile)| {
            let name = name.clone();
            match stored.is_at(&folder.join(&name)) {
                Ok(true) => None,
                Ok(false) => Some(Difference::Changed(name)),
                Err(error) if error.kind() == io::ErrorKind::NotFound => Some(Difference::Missing(name)),
                Err(error) => Some(Difference::Unreadable(name, error.to_string())),
            }
        };
        let of_folder = |name: &String| {
            let path = format!("{name}/{MANIFEST}");
            (!folder.join(&path).is_file()).then_some(Difference::Missing(path))
        };
        self.files.iter().filter_map(of_file).chain(self.folders.keys().filter_map(of_folder)).collect()
    }
}

fn sealed(text: &str) -> String {
    sha256(text.as_bytes())
}

impl StoredFile {
    /// True if a file has this size and this content.
    ///
    /// # Errors
    /// The errors of reading.
    pub fn is_at(&self, path: &Path) -> io::Result<bool> {
        let mut file = File::open(path)?;
        if !file.metadata()?.is_file() || file.metadata()?.len() != self.bytes {
            return Ok(false);
        }
        let mut hash = Sha256::new();
        let mut piece = vec![0; 1 << 18];
        loop {
            match file.read(&mut piece)? {
                0 => return Ok(hexadecimal(&hash.finalize()) == self.sha256),
                length => hash.update(&piece[..length]),
            }
        }
    }
}

/// `manifest.json`, for its schema.
#[derive(Debug, JsonSchema)]
#[expect(dead_code, reason = "describes a file")]
pub struct ManifestFile {
    /// Version of the program that wrote the file.
    trocar_version: String,
    /// The subfolders of a comparison or of many recordings, each with the command that wrote it.
    folders: BTreeMap<String, String>,
    /// The files by their path within the folder.
    files: BTreeMap<String, StoredFile>,
    /// SHA-256 of this file, with an empty string in this field.
    manifest_sha256: String,
}
