//! The moves of a folder, and its new manifest.

use std::collections::BTreeMap;
use std::fs::Metadata;
use std::io;
use std::path::{Path, PathBuf};

use super::journal::{UnitJournal, copy_name};
use super::manifest::{MANIFEST, Manifest};
use super::swap::Identity;
use super::{Unit, lock, ops, recovery};
use crate::OutputError;

/// Plans the moves of a staged folder, and stages its manifest and, for an exchange of folders, links to the files of
/// others. `folders` are the subfolders with their commands.
pub(super) fn plan(
    root: &Path,
    stage: &Path,
    index: usize,
    unit: &Unit,
    folders: &[(&str, &str)],
) -> Result<UnitJournal, OutputError> {
    let (target, staged) = (root.join(&unit.name), stage.join(index.to_string()));
    let failed = |source| OutputError::Write { path: target.clone(), source };
    // The files of a damaged manifest count as files of others.
    let old = Manifest::read(&target).unwrap_or_default();
    let stale = stale(&old, unit);
    let text = merged(old, unit, folders).text();
    let path = staged.join(MANIFEST);
    ops::write(&path, text.as_bytes()).map_err(failed)?;
    ops::all(std::slice::from_ref(&path), |_| ops::sync_file(&path)).map_err(failed)?;
    let files: Vec<String> = unit.files.keys().cloned().collect();
    let can_be_exchanged = !unit.name.is_empty() && adopt(&target, &staged, &stale).map_err(failed)?;
    let exchange = if can_be_exchanged { Identity::of(&staged) } else { None };
    check_moves(&target, &files)?;
    if exchange.is_none() {
        check_writable(&target).map_err(failed)?;
    }
    for folder in files.iter().filter_map(|name| Path::new(name).parent()).chain([Path::new("")]) {
        ops::sync_folder(&staged.join(folder)).map_err(failed)?;
    }
    Ok(UnitJournal { folder: unit.name.clone(), staged: index.to_string(), exchange, files, stale })
}

/// Returns the files of the former generation that the new one lacks, with their hashes.
fn stale(old: &Manifest, unit: &Unit) -> BTreeMap<String, String> {
    let is_stale = |name: &str, by: &str| by == unit.command && !unit.files.contains_key(name);
    let stale = old.files.iter().filter(|(name, file)| is_stale(name, &file.written_by));
    stale.map(|(name, file)| (name.clone(), file.sha256.clone())).collect()
}

/// The files of other commands stay; those of this command are the new ones.
fn merged(old: Manifest, unit: &Unit, folders: &[(&str, &str)]) -> Manifest {
    let mut new = old;
    new.files.retain(|_, file| file.written_by != unit.command);
    new.files.extend(unit.files.clone());
    new.folders.retain(|_, by| *by != unit.command);
    new.folders.extend(folders.iter().map(|(name, _)| ((*name).to_owned(), unit.command.to_owned())));
    new.details.extend(unit.details.clone());
    new
}

/// Links the files of others into the staged folder, so that an exchange keeps them. Returns false if the folder
/// cannot be exchanged.
fn adopt(target: &Path, staged: &Path, stale: &BTreeMap<String, String>) -> io::Result<bool> {
    let there = match std::fs::symlink_metadata(target) {
        // The new folder gets the name.
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(true),
        there => there?,
    };
    if !there.is_dir() || !have_one_owner(&there, &std::fs::metadata(staged)?) {
        return Ok(false);
    }
    let mut others = vec![];
    for entry in std::fs::read_dir(target)? {
        let entry = entry?;
        let name = entry.file_name();
        let is_file = entry.file_type()?.is_file();
        let is_left = |name: &str| recovery::is_temporary(name) && lock::is_left(&entry.path());
        let is_dropped = |name: &str| stale.contains_key(name) || is_left(name);
        if is_file && (staged.join(&name).exists() || name.to_str().is_some_and(is_dropped)) {
            continue;
        }
        if !is_file {
            return Ok(false);
        }
        others.push(name);
    }
    std::fs::set_permissions(staged, there.permissions())?;
    // Where files cannot be linked, they are not moved.
    Ok(others.iter().all(|name| ops::link(&target.join(name), &staged.join(name)).is_ok()))
}

#[cfg(unix)]
fn have_one_owner(one: &Metadata, other: &Metadata) -> bool {
    use std::os::unix::fs::MetadataExt as _;
    (one.uid(), one.gid(), one.dev()) == (other.uid(), other.gid(), other.dev())
}

#[cfg(not(unix))]
fn have_one_owner(_one: &Metadata, _other: &Metadata) -> bool {
    true
}

/// Refuses moves that would fail, before anything is moved.
fn check_moves(target: &Path, files: &[String]) -> Result<(), OutputError> {
    let refused = |path: PathBuf, kind: io::ErrorKind| Err(OutputError::Write { path, source: kind.into() });
    for path in files.iter().map(|name| target.join(name)).chain([target.join(MANIFEST)]) {
        if path.is_dir() {
            return refused(path, io::ErrorKind::IsADirectory);
        }
        let within = path.ancestors().skip(1).take_while(|folder| folder.starts_with(target));
        if let Some(file) = within.filter(|folder| folder.exists()).find(|folder| !folder.is_dir()) {
            return refused(file.to_owned(), io::ErrorKind::NotADirectory);
        }
    }
    Ok(())
}

/// Tries to write into a folder, if there is one.
fn check_writable(target: &Path) -> io::Result<()> {
    if !target.is_dir() {
        return Ok(());
    }
    let probe = target.join(copy_name("probe"));
    std::fs::write(&probe, b"")?;
    std::fs::remove_file(&probe)
}
