use std::io;
use std::path::Path;

use serde_json::{Map, Value as Json};

use super::{CASES, SWEEP, WRITER};
use crate::cli::error::Failure;
use crate::cli::report::FILE as REPORT;
use trocar_document::json_of;
use trocar_report::{MANIFEST, OutputError, write_file};
use trocar_studies::sweep::{Manifest, SweepError, difference};

pub(super) struct Stored {
    manifest: trocar_report::Manifest,
    /// `None` if the folder has no manifest of this sweep.
    sweep: Option<Manifest>,
    /// Reasons to run a complete sweep again.
    differences: Vec<String>,
    /// Also if the manifest is damaged.
    has_report: bool,
}

impl Stored {
    /// Another sweep in the folder is an error.
    pub(super) fn of(folder: &Path, canonical: &str, hash: &str) -> Result<Self, Failure> {
        let manifest = trocar_report::Manifest::of(folder);
        let mut differences = vec![];
        let sweep = serde_json::from_value(Json::Object(manifest.details.clone())).ok();
        let sweep = sweep.filter(|sweep: &Manifest| sweep.sweep_sha256 == hash);
        match std::fs::read_to_string(folder.join(SWEEP)) {
            Ok(existing) if existing == canonical => {}
            // The manifest is of this sweep, so its file was damaged.
            _ if sweep.is_some() => differences.push(format!("{SWEEP} is missing or was changed")),
            Ok(existing) => {
                let difference = difference(&existing, canonical);
                return Err(SweepError::Changed { folder: folder.to_owned(), difference }.into());
            }
            Err(error) if error.kind() == io::ErrorKind::NotFound => {}
            Err(source) => return Err(SweepError::Io { path: folder.join(SWEEP), source }.into()),
        }
        let is_missing = |name: &&String| *name != SWEEP && !folder.join(name).is_file();
        differences.extend(manifest.files.keys().filter(is_missing).map(|name| format!("{name} is missing")));
        let has_report = manifest.files.contains_key(REPORT) || folder.join(REPORT).is_file();
        Ok(Self { manifest, sweep, differences, has_report })
    }

    /// True if the sweep is complete, with all of its files.
    pub(super) fn is_complete(&self) -> bool {
        self.differences.is_empty() && self.sweep.as_ref().is_some_and(|sweep| sweep.is_complete)
    }

    pub(super) fn has_report(&self) -> bool {
        self.has_report
    }

    pub(super) fn print_differences(&self) {
        for difference in &self.differences {
            anstream::eprintln!("note: {difference}; the sweep runs again");
        }
    }

    /// The manifest of the same sweep stays: its files will have the same content.
    pub(super) fn begin(&self, folder: &Path, sweep: &Manifest) -> Result<(), OutputError> {
        if self.sweep.is_some() {
            return Ok(());
        }
        let manifest = trocar_report::Manifest { details: details(sweep), ..self.manifest.clone() };
        write_file(&folder.join(MANIFEST), manifest.text().as_bytes())
    }
}

pub(super) fn details(sweep: &Manifest) -> Map<String, Json> {
    match json_of(sweep) {
        Json::Object(fields) => fields,
        _ => Map::new(),
    }
}

/// The sweep file is last, so after an interruption the others still belong to it.
pub(super) fn remove_another(folder: &Path, canonical: &str) -> Result<(), Failure> {
    if std::fs::read_to_string(folder.join(SWEEP)).map_or(true, |existing| existing == canonical) {
        return Ok(());
    }
    let manifest = trocar_report::Manifest::of(folder);
    let files = manifest.files.iter().filter(|(name, writer)| *writer == WRITER && *name != SWEEP);
    for name in files.map(|(name, _)| name.as_str()).chain([CASES, MANIFEST, SWEEP]) {
        match std::fs::remove_file(folder.join(name)) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => {
                return Err(SweepError::Io { path: folder.join(name), source: error }.into());
            }
            _ => {}
        }
    }
    Ok(())
}
