use std::path::{Path, PathBuf};

use clap::Args;

use super::finish::{Whole, finish};
use super::stored::Stored;
use super::{Manifest, OutputArgs, WRITER};
use crate::cli::error::Failure;
use crate::cli::report as page;
use crate::cli::warnings::Warnings;
use trocar_report::MANIFEST;
use trocar_report::html::command_line;
use trocar_studies::sweep::{Joined, SweepError, join};

const EXAMPLES: &str = "\
Example:
  trocar sweep merge out/big";

/// Join the parts of a sweep.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES, mut_arg("out", |arg| arg.help(crate::cli::OUT_PER_SWEEP)))]
pub(super) struct MergeArgs {
    /// Folders of shards, or folders that contain them
    #[arg(required = true, value_name = "DIR")]
    folders: Vec<PathBuf>,
    /// Also write report.html, as `trocar sweep --report` does
    #[arg(long)]
    report: bool,
    #[command(flatten)]
    output: OutputArgs,
}

pub(super) fn run(args: &MergeArgs) -> Result<(), Failure> {
    let mut folders = vec![];
    for folder in &args.folders {
        folders.extend(shards(folder)?);
    }
    let Joined { design, canonical, hash, rows } = join(&folders)?;
    let folder = args.output.destination().open(WRITER, &design.name)?;
    // Another sweep in this folder is an error.
    Stored::of(&folder.path, &canonical, &hash)?;
    let manifest =
        Manifest { sweep_sha256: hash, cases: design.cases(), part: (0, design.cases()), is_complete: false };
    let line = args.report.then(|| {
        let folders = args.folders.iter().map(|folder| page::shown(&folder.to_string_lossy()));
        let words = ["sweep".to_owned(), "merge".to_owned()].into_iter().chain(folders);
        command_line(words.chain(["--report".to_owned()]))
    });
    let warnings = Warnings::new(&args.output);
    let whole = Whole { design: &design, canonical: &canonical, manifest, rows, report: line, printed: vec![] };
    finish(&folder, whole, &args.output, &warnings)?;
    warnings.finish()
}

fn shards(folder: &Path) -> Result<Vec<PathBuf>, Failure> {
    let is_shard = |path: &Path| {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        name.starts_with("shard-") && path.join(MANIFEST).is_file()
    };
    let inside = || -> std::io::Result<Vec<PathBuf>> {
        let paths = std::fs::read_dir(folder)?.map(|entry| Ok(entry?.path()));
        let mut paths = paths.collect::<std::io::Result<Vec<_>>>()?;
        paths.retain(|path| is_shard(path));
        paths.sort();
        Ok(paths)
    };
    let found = inside().map_err(|error| SweepError::Parts { message: format!("{}: {error}", folder.display()) })?;
    Ok(if found.is_empty() { vec![folder.to_owned()] } else { found })
}
