//! `trocar verify`.

use std::path::{Path, PathBuf};

use clap::Args;

use super::error::CliError;
use super::terminal;
use trocar_document::counted;
use trocar_report::{Difference, MANIFEST, Manifest, ManifestError, recover};

const EXAMPLES: &str = "\
Examples:
  trocar verify out
  trocar verify out/classical";

/// Levels of subfolders that are searched for manifests.
const DEPTH: usize = 4;

type Found = (PathBuf, Result<Manifest, ManifestError>);

/// Check folders against their manifests.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct VerifyArgs {
    /// Folders with a manifest.json, or with subfolders that have one
    #[arg(required = true, value_name = "DIR")]
    folders: Vec<PathBuf>,
    /// Print errors only
    #[arg(long, short)]
    quiet: bool,
}

pub(super) fn run(args: &VerifyArgs) -> Result<(), CliError> {
    let mut differences = 0;
    for folder in &args.folders {
        let inside = folder.canonicalize().ok().and_then(|path| Some(path.parent()?.to_owned()));
        for root in [Some(folder.clone()), inside].into_iter().flatten() {
            recover(&root)?;
        }
        let (mut folders, mut unknown) = (vec![], vec![]);
        find(folder, DEPTH, &mut folders, &mut unknown);
        if folders.is_empty() {
            return Err(CliError::NoManifest { folder: folder.display().to_string() });
        }
        for (folder, files) in unknown.iter().filter(|_| !args.quiet) {
            let (folder, files) = (folder.display(), counted(*files, "file"));
            anstream::eprintln!("note: {folder} has no {MANIFEST}: {files} directly in it cannot be compared");
        }
        for (folder, manifest) in folders {
            let (files, found) = compare(&folder, manifest);
            for difference in &found {
                anstream::eprintln!("error: {}: {difference}", folder.display());
            }
            differences += found.len();
            if !args.quiet && found.is_empty() {
                terminal::print(&format!("{}: {} unchanged\n", folder.display(), counted(files as u64, "file")))?;
            }
        }
    }
    if differences > 0 { Err(CliError::Differences { count: differences }) } else { Ok(()) }
}

/// Finds the folders with a manifest, and those with files but without one, whose files no manifest above names.
fn find(folder: &Path, depth: usize, found: &mut Vec<Found>, unknown: &mut Vec<(PathBuf, u64)>) {
    let manifest = Manifest::read(folder);
    let files = files_of(folder);
    let is_named = |inner: &Path| {
        let (Ok(manifest), Some(name)) = (&manifest, inner.file_name()) else { return false };
        let name = format!("{}/", name.to_string_lossy());
        manifest.files.keys().any(|file| file.starts_with(&name))
    };
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let folders = entries.filter(|entry| entry.file_type().is_ok_and(|kind| kind.is_dir()));
    let mut folders: Vec<PathBuf> = folders.map(|entry| entry.path()).filter(|inner| !is_named(inner)).collect();
    folders.sort();
    match manifest {
        Err(ManifestError::Missing { .. }) if files > 0 => unknown.push((folder.to_owned(), files)),
        Err(ManifestError::Missing { .. }) => {}
        manifest => found.push((folder.to_owned(), manifest)),
    }
    if let Some(depth) = depth.checked_sub(1) {
        folders.iter().for_each(|inner| find(inner, depth, found, unknown));
    }
}

fn files_of(folder: &Path) -> u64 {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    entries.filter(|entry| entry.file_type().is_ok_and(|kind| kind.is_file())).count() as u64
}

/// Returns the number of files and the differences of a folder.
fn compare(folder: &Path, manifest: Result<Manifest, ManifestError>) -> (usize, Vec<String>) {
    match manifest {
        Ok(manifest) => {
            let found: Vec<String> = manifest.differences(folder).iter().map(Difference::to_string).collect();
            (manifest.files.len(), found)
        }
        Err(ManifestError::Missing { .. }) => (0, vec![format!("{MANIFEST} is missing")]),
        Err(ManifestError::Damaged { reason, .. }) => (0, vec![format!("{MANIFEST} is damaged: {reason}")]),
    }
}
