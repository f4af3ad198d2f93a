//! The new folder of a command, until it replaces the old one.
//!
//! A command writes into `DIR/.trocar-PID-XXXXXX/new`. At its end, this folder is exchanged with `DIR/NAME` in one step,
//! and the old one is removed. Where the system cannot exchange folders, the old one is first moved to `old` in the
//! stage.
//!
//! The file `lock` in the stage contains NAME. Its process holds a lock of the operating system on it. The next command
//! in `DIR` removes the stages whose lock is free, and first moves an old folder back if the new one is not in its
//! place. On file systems without locks, stages of killed commands stay.

use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

use serde_json::{Map, Value as Json};

use super::OutputError;
use super::files::{remove_left_files, temporaries, temporary_prefix};
use super::manifest::{MANIFEST, Manifest};

const LOCK: &str = "lock";
const NEW: &str = "new";
const OLD: &str = "old";

/// The stages of this process, each with its output folder if this process has created it. Each commit locks them, so
/// Ctrl-C waits for its end.
static LIVE: Mutex<Vec<(PathBuf, Option<PathBuf>)>> = Mutex::new(vec![]);

fn live() -> MutexGuard<'static, Vec<(PathBuf, Option<PathBuf>)>> {
    LIVE.lock().unwrap_or_else(PoisonError::into_inner)
}

#[derive(Debug)]
pub(super) struct Stage {
    path: PathBuf,
    root: PathBuf,
    target: PathBuf,
    _lock: File,
}

impl Stage {
    /// Cleans up after killed commands, too.
    pub(super) fn begin(root: &Path, name: &str) -> Result<Self, OutputError> {
        let made_root = (!root.exists()).then(|| root.to_owned());
        let mut target = root.join(name);
        let (mut root, mut name) = (root.to_owned(), name.to_owned());
        if target.is_symlink() {
            // Replaces the folder, not the link to it.
            target = target.canonicalize().map_err(failed(&target))?;
            root = target.parent().unwrap_or(&target).to_owned();
            name = target.file_name().unwrap_or_default().to_string_lossy().into_owned();
        }
        if target.exists() && !target.is_dir() {
            return Err(failed(&target)(io::ErrorKind::NotADirectory.into()));
        }
        fs::create_dir_all(&root).map_err(failed(&root))?;
        let mut live = live();
        let _exclusive = exclusive(&root);
        clean(&root);
        let create = || -> io::Result<(PathBuf, File)> {
            let path = tempfile::Builder::new().prefix(&temporary_prefix()).tempdir_in(&root)?.keep();
            fs::write(path.join(LOCK), &name)?;
            let lock = File::options().write(true).open(path.join(LOCK))?;
            let _ = lock.try_lock();
            fs::create_dir(path.join(NEW))?;
            Ok((path, lock))
        };
        let (path, lock) = create().map_err(failed(&root))?;
        live.push((path.clone(), made_root));
        Ok(Self { path, root, target, _lock: lock })
    }

    pub(super) fn new_folder(&self) -> PathBuf {
        self.path.join(NEW)
    }

    /// Files that the command has not written stay.
    pub(super) fn commit(&self, command: &str, details: Map<String, Json>) -> Result<(), OutputError> {
        let mut live = live();
        let _exclusive = exclusive(&self.root);
        // A command that was killed meanwhile may have moved the old folder aside.
        clean(&self.root);
        self.complete(command, details)?;
        self.replace().map_err(failed(&self.target))?;
        remove(&self.path);
        live.retain(|(path, _)| *path != self.path);
        Ok(())
    }

    /// Adds the manifest and the files of others to the new folder.
    fn complete(&self, command: &str, details: Map<String, Json>) -> Result<(), OutputError> {
        let (new, failed_here) = (self.new_folder(), failed(&self.target));
        let old = Manifest::of(&self.target);
        let mut manifest = old.clone();
        manifest.files.retain(|_, writer| writer != command);
        let files = files_below(&new).map_err(&failed_here)?;
        manifest.files.extend(files.iter().map(|path| (manifest_name(path), command.to_owned())));
        manifest.details.extend(details);
        fs::write(new.join(MANIFEST), manifest.text()).map_err(&failed_here)?;
        let is_old = |path: &PathBuf| old.files.get(&manifest_name(path)).is_some_and(|writer| writer == command);
        if !self.target.is_dir() {
            return Ok(());
        }
        for path in files_below(&self.target).map_err(&failed_here)?.iter().filter(|path| !is_old(path)) {
            let old = self.target.join(path);
            keep(&old, &new.join(path)).map_err(failed(&old))?;
        }
        let permissions = fs::metadata(&self.target).map_err(&failed_here)?.permissions();
        fs::set_permissions(&new, permissions).map_err(&failed_here)
    }

    fn replace(&self) -> io::Result<()> {
        let (new, old, target) = (self.new_folder(), self.path.join(OLD), &self.target);
        fs::create_dir_all(target.parent().unwrap_or(&self.root))?;
        if !target.exists() {
            return fs::rename(&new, target);
        }
        exchange(&new, target).or_else(|_| move_aside(&new, &old, target))
    }
}

impl Drop for Stage {
    fn drop(&mut self) {
        let mut live = live();
        if let Some(index) = live.iter().position(|(path, _)| *path == self.path) {
            discard(&live.swap_remove(index));
        }
    }
}

/// Removes the stages of this process, before it ends. Returns true if there was one.
pub fn discard_all() -> bool {
    let live = live();
    live.iter().for_each(discard);
    let is_any = !live.is_empty();
    // No commit begins before the process ends.
    std::mem::forget(live);
    is_any
}

fn discard((stage, made_root): &(PathBuf, Option<PathBuf>)) {
    remove(stage);
    if let Some(root) = made_root {
        let _ = fs::remove_dir(root);
    }
}

/// Removes the lock last. The next command removes the rest.
fn remove(stage: &Path) {
    for path in [stage.join(NEW), stage.join(OLD), stage.to_owned()] {
        // A file that another thread writes at this moment is removed at the second attempt.
        let _ = fs::remove_dir_all(&path).or_else(|_| fs::remove_dir_all(&path));
    }
}

fn clean(root: &Path) {
    remove_left_files(root);
    for stage in temporaries(root).filter(|path| path.is_dir()) {
        match File::options().read(true).write(true).open(stage.join(LOCK)) {
            Ok(lock) if lock.try_lock().is_ok() => {
                if let Ok(name) = io::read_to_string(&lock) {
                    // Fails if the new folder is in its place.
                    let _ = fs::rename(stage.join(OLD), root.join(name));
                }
                remove(&stage);
            }
            Ok(_) => {}
            // The process ended before it had a lock, so the stage is empty.
            Err(_) => drop(fs::remove_dir(&stage)),
        }
    }
}

/// Excludes other commands, for milliseconds, where folders can be locked.
fn exclusive(root: &Path) -> Option<File> {
    let folder = File::open(root).ok()?;
    folder.lock().ok().map(|()| folder)
}

fn failed(path: &Path) -> impl Fn(io::Error) -> OutputError + use<'_> {
    move |source| OutputError::Write { path: path.to_owned(), source }
}

/// Returns the paths of the files within a folder, without temporary ones.
fn files_below(folder: &Path) -> io::Result<Vec<PathBuf>> {
    let left: Vec<PathBuf> = temporaries(folder).collect();
    let mut found = vec![];
    for entry in fs::read_dir(folder)? {
        let entry = entry?;
        let name = PathBuf::from(entry.file_name());
        if left.contains(&entry.path()) {
            continue;
        }
        if entry.file_type()?.is_dir() {
            found.extend(files_below(&entry.path())?.into_iter().map(|inner| name.join(inner)));
        } else {
            found.push(name);
        }
    }
    Ok(found)
}

fn manifest_name(path: &Path) -> String {
    path.to_string_lossy().replace(std::path::MAIN_SEPARATOR, "/")
}

/// Keeps a file of the old folder, unless the new one has a file of this name.
fn keep(old: &Path, new: &Path) -> io::Result<()> {
    if new.is_dir() {
        return Err(io::ErrorKind::IsADirectory.into());
    }
    if new.exists() {
        return Ok(());
    }
    fs::create_dir_all(new.parent().unwrap_or(new))?;
    match fs::hard_link(old, new).or_else(|_| fs::copy(old, new).map(drop)) {
        // Its owner has just removed it.
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(()),
        kept => kept,
    }
}

/// Replaces a folder where the system cannot exchange it.
fn move_aside(new: &Path, old: &Path, target: &Path) -> io::Result<()> {
    fs::rename(target, old)?;
    fs::rename(new, target).inspect_err(|_| drop(fs::rename(old, target)))
}

#[cfg(any(target_os = "linux", target_os = "macos"))]
fn exchange(one: &Path, other: &Path) -> io::Result<()> {
    use rustix::fs::{CWD, RenameFlags, renameat_with};
    Ok(renameat_with(CWD, one, CWD, other, RenameFlags::EXCHANGE)?)
}

#[cfg(not(any(target_os = "linux", target_os = "macos")))]
fn exchange(_one: &Path, _other: &Path) -> io::Result<()> {
    Err(io::ErrorKind::Unsupported.into())
}

#[cfg(test)]
mod tests;
