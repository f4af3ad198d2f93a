//! The operations on the file system. Tests end the process at each of them.

use std::fs::File;
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};

#[cfg(test)]
pub(super) use super::tests::crash::is_crashed;
#[cfg(test)]
use super::tests::crash::point;

/// A place where a test can end the process.
#[cfg(not(test))]
#[inline]
fn point(_name: &str, _path: &Path) -> io::Result<()> {
    Ok(())
}

#[cfg(not(test))]
pub(super) const fn is_crashed() -> bool {
    false
}

pub(super) fn create_folder(path: &Path) -> io::Result<()> {
    point("create", path)?;
    std::fs::create_dir_all(path)
}

/// Writes a file without the guarantee of its old or new content.
pub(super) fn write(path: &Path, content: &[u8]) -> io::Result<()> {
    let (first, rest) = content.split_at(content.len() / 2);
    let mut file = File::create(path)?;
    file.write_all(first)?;
    point("write", path)?;
    file.write_all(rest)
}

pub(super) fn rename(from: &Path, to: &Path) -> io::Result<()> {
    point("rename", to)?;
    std::fs::rename(from, to)
}

pub(super) fn remove_file(path: &Path) -> io::Result<()> {
    point("remove", path)?;
    std::fs::remove_file(path)
}

pub(super) fn remove_all(path: &Path) -> io::Result<()> {
    point("remove", path)?;
    std::fs::remove_dir_all(path)
}

pub(super) fn link(from: &Path, to: &Path) -> io::Result<()> {
    point("link", to)?;
    std::fs::hard_link(from, to)
}

pub(super) fn sync_file(path: &Path) -> io::Result<()> {
    // Windows flushes only files that are open for writing.
    File::options().write(true).open(path)?.sync_all()
}

/// Performs an operation on many files; tests see each of them.
pub(super) fn all(files: &[PathBuf], work: impl FnOnce(&[PathBuf]) -> io::Result<()>) -> io::Result<()> {
    files.iter().try_for_each(|file| point("sync", file))?;
    work(files)
}

/// Syncs the entries of a folder, where the operating system can.
pub(crate) fn sync_folder(path: &Path) -> io::Result<()> {
    point("sync", path)?;
    if cfg!(unix) { File::open(path)?.sync_all() } else { Ok(()) }
}

/// Exchanges two folders in one step.
///
/// # Errors
/// [`io::ErrorKind::Unsupported`] if the operating system cannot do this.
#[cfg(any(target_os = "linux", target_os = "macos"))]
pub(super) fn exchange(one: &Path, other: &Path) -> io::Result<()> {
    use rustix::fs::{CWD, RenameFlags, renameat_with};
    point("exchange", other)?;
    Ok(renameat_with(CWD, one, CWD, other, RenameFlags::EXCHANGE)?)
}

#[cfg(not(any(target_os = "linux", target_os = "macos")))]
pub(super) fn exchange(_one: &Path, _other: &Path) -> io::Result<()> {
    Err(io::ErrorKind::Unsupported.into())
}
