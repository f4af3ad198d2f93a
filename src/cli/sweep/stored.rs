//! The files of a sweep that a folder contains already.

use std::io;
use std::path::Path;

use serde_json::{Map, Value as Json};

use super::{CASES, SWEEP, WRITER};
use crate::cli::error::CliError;
use crate::cli::report::FILE as REPORT;
use trocar_document::json_of;
use trocar_report::{MANIFEST, ManifestError, OutputError, StoredFile, write_file};
use trocar_studies::sweep::{Manifest, SweepError, difference};

pub(super) struct Stored {
    manifest: trocar_report::Manifest,
    /// The fields of the sweep; `None` if the folder has no intact manifest of this sweep.
    sweep: Option<Manifest>,
    /// Files that are missing or changed.
    differences: Vec<String>,
    /// True if the folder has a report, also if its manifest is damaged.
    has_report: bool,
}

impl Stored {
    /// Reads the folder of a sweep, and compares its files with its manifest. Another sweep there is an error.
    pub(super) fn of(folder: &Path, canonical: &str, hash: &str) -> Result<Self, CliError> {
        let (manifest, mut differences) = match trocar_report::Manifest::read(folder) {
            Ok(manifest) => (manifest, vec![]),
            Err(ManifestError::Missing { .. }) => (trocar_report::Manifest::default(), vec![]),
            Err(damaged) => (trocar_report::Manifest::default(), vec![damaged.to_string()]),
        };
        let sweep = serde_json::from_value(Json::Object(manifest.details.clone())).ok();
        let sweep = sweep.filter(|sweep: &Manifest| sweep.sweep_sha256 == hash);
        match std::fs::read_to_string(folder.join(SWEEP)) {
            Ok(existing) if existing == canonical => {}
            // The manifest says that the folder belongs to this sweep, so its file was damaged.
            _ if sweep.is_some() => differences.push(format!("{SWEEP} is missing or was changed")),
            Ok(existing) => {
                let difference = difference(&existing, canonical);
                return Err(SweepError::Changed { folder: folder.to_owned(), difference }.into());
            }
            Err(error) if error.kind() == io::ErrorKind::NotFound => {}
            Err(source) => return Err(SweepError::Io { path: folder.join(SWEEP), source }.into()),
        }
        if sweep.as_ref().is_some_and(|sweep| sweep.is_complete) {
            let found = manifest.differences(folder);
            differences.extend(found.iter().map(ToString::to_string).filter(|text| !text.starts_with(SWEEP)));
        }
        let has_report = match &sweep {
            Some(_) => manifest.files.contains_key(REPORT),
            None => folder.join(REPORT).is_file(),
        };
        Ok(Self { manifest, sweep, differences, has_report })
    }

    /// True if the sweep is complete, with every file as it was written.
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

    /// Writes the manifest of a sweep that is not complete. The manifest of the same sweep stays: its files will have
    /// the same content.
    pub(super) fn begin(&self, folder: &Path, sweep: &Manifest) -> Result<(), OutputError> {
        if self.sweep.is_some() {
            return Ok(());
        }
        let mut manifest = self.manifest.clone();
        manifest.files.retain(|_, file| !is_of_sweep(file));
        manifest.details = details(sweep);
        write_file(&folder.join(MANIFEST), manifest.text().as_bytes())
    }
}

pub(super) fn details(sweep: &Manifest) -> Map<String, Json> {
    match json_of(sweep) {
        Json::Object(fields) => fields,
        _ => Map::new(),
    }
}

fn is_of_sweep(file: &StoredFile) -> bool {
    file.written_by == WRITER
}

/// Removes the files of another sweep. The sweep file is last, so after an interruption they still belong to it.
pub(super) fn remove_another(folder: &Path, canonical: &str) -> Result<(), CliError> {
    if std::fs::read_to_string(folder.join(SWEEP)).map_or(true, |existing| existing == canonical) {
        return Ok(());
    }
    let manifest = trocar_report::Manifest::read(folder).unwrap_or_default();
    let files = manifest.files.iter().filter(|(name, file)| is_of_sweep(file) && *name != SWEEP);
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
