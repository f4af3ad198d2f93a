use std::ops::Range;
use std::path::{Path, PathBuf};

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::canonical::sha256;
use super::design::Design;
use super::error::SweepError;
use super::part::{PACK_CASES, Part, Rows};
use super::plan::{layout, stored_design};
use trocar_scenario::Source;

/// The description of the part in a folder.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct Manifest {
    /// SHA-256 of the folder's `sweep.toml`, which contains all inputs of the sweep.
    pub sweep_sha256: String,
    /// Number of cases of the whole sweep.
    pub cases: u64,
    /// First case of this part, and one past its last case.
    pub part: (u64, u64),
    /// True if the tables are written and the part file is removed.
    pub is_complete: bool,
}

pub const MANIFEST: &str = "manifest.json";
pub const SWEEP: &str = "sweep.toml";
pub const CASES: &str = "cases.part";

#[derive(Debug)]
pub struct Joined {
    pub design: Design,
    /// All inputs of the sweep.
    pub canonical: String,
    /// SHA-256 of the inputs.
    pub hash: String,
    pub rows: Rows,
}

struct FolderPart {
    folder: PathBuf,
    hash: String,
    packs: Range<u64>,
}

fn parts_error<T>(message: String) -> Result<T, SweepError> {
    Err(SweepError::Parts { message })
}

fn read(path: &Path) -> Result<String, SweepError> {
    std::fs::read_to_string(path).or_else(|error| parts_error(format!("{} cannot be read: {error}", path.display())))
}

/// Verifies that the parts belong to one sweep and contain every case once.
pub fn join(folders: &[PathBuf]) -> Result<Joined, SweepError> {
    let mut found = folders.iter().map(|folder| read_part(folder)).collect::<Result<Vec<_>, _>>()?;
    found.retain(|part| !part.packs.is_empty());
    found.sort_by_key(|part| (part.packs.start, part.packs.end));
    let Some(first) = found.first() else {
        return parts_error("none of the folders contains a part with cases".into());
    };
    if let Some(other) = found.iter().find(|part| part.hash != first.hash) {
        let (one, other) = (&first.folder, &other.folder);
        let difference = super::plan::difference(&read(&one.join(SWEEP))?, &read(&other.join(SWEEP))?);
        let (one, other) = (one.display(), other.display());
        return parts_error(format!(
            "{one} and {other} belong to different sweeps:\n{difference}join the parts of one sweep"
        ));
    }
    let source = Source::Disk(first.folder.join(SWEEP));
    let design = stored_design(&source)?;
    let canonical = read(&first.folder.join(SWEEP))?;
    let mut next = 0;
    for part in &found {
        let (start, folder) = (part.packs.start, part.folder.display());
        if start < next {
            let case = start * PACK_CASES;
            return parts_error(format!(
                "{folder} has case {case}, which is also in another part; name each part once"
            ));
        }
        if start > next {
            return parts_error(missing(&design, next..start));
        }
        next = part.packs.end;
    }
    let packs = design.cases().div_ceil(PACK_CASES);
    if next < packs {
        return parts_error(missing(&design, next..packs));
    }
    let mut parts = vec![];
    for part in &found {
        let layout = layout(&design, &canonical, part.packs.clone());
        let file = Part::open_existing(&part.folder.join(CASES), layout)?;
        let (done, all) = (file.cases_done()?, file.layout().part_cases());
        if done < all {
            let folder = part.folder.display();
            return parts_error(format!(
                "{folder} has {done} of its {all} cases; the command that started it continues it"
            ));
        }
        parts.push(file);
    }
    let hash = first.hash.clone();
    Ok(Joined { design, canonical, hash, rows: Rows(parts) })
}

fn missing(design: &Design, packs: Range<u64>) -> String {
    let last = (packs.end * PACK_CASES).min(design.cases()) - 1;
    format!("the cases {} to {last} are in none of the parts; run their shards", packs.start * PACK_CASES)
}

fn read_part(folder: &Path) -> Result<FolderPart, SweepError> {
    let path = folder.join(MANIFEST);
    let manifest: Manifest = match serde_json::from_str(&read(&path)?) {
        Ok(manifest) => manifest,
        Err(error) => return parts_error(format!("{} is not the manifest of a sweep: {error}", path.display())),
    };
    if manifest.is_complete {
        return parts_error(format!("{} is a complete sweep; name the folders of shards", folder.display()));
    }
    let hash = sha256(read(&folder.join(SWEEP))?.as_bytes());
    if hash != manifest.sweep_sha256 {
        let (sweep, folder) = (SWEEP, folder.display());
        return parts_error(format!("{folder}: {sweep} was changed after the start of the part; run the shard again"));
    }
    let (start, end) = manifest.part;
    if start % PACK_CASES != 0 || (end % PACK_CASES != 0 && end != manifest.cases) || start > end {
        return parts_error(format!("{}: a part cannot have the cases {start} to {end}", path.display()));
    }
    Ok(FolderPart { folder: folder.to_owned(), hash, packs: start / PACK_CASES..end.div_ceil(PACK_CASES) })
}
