use std::collections::BTreeMap;
use std::path::Path;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value as Json};

pub const MANIFEST: &str = "manifest.json";

/// `manifest.json`.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct Manifest {
    /// Version of the program that wrote the file.
    pub trocar_version: String,
    /// The files by their path within the folder, each with the command that wrote it.
    pub files: BTreeMap<String, String>,
    /// Further fields of a command.
    #[serde(flatten)]
    #[schemars(skip)]
    pub details: Map<String, Json>,
}

impl Manifest {
    /// A manifest that is missing or damaged is empty, so the files there count as the user's.
    pub fn of(folder: &Path) -> Self {
        let text = std::fs::read(folder.join(MANIFEST)).unwrap_or_default();
        serde_json::from_slice(&text).unwrap_or_default()
    }

    /// Includes the version of this program.
    pub fn text(&self) -> String {
        let manifest = Self { trocar_version: env!("CARGO_PKG_VERSION").to_owned(), ..self.clone() };
        // Maps with names as keys are always valid JSON.
        let json = serde_json::to_value(manifest).unwrap_or_default();
        format!("{json:#}\n")
    }
}
