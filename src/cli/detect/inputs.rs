//! Which recordings are meant, and the folders that they write into.

use std::collections::HashSet;
use std::path::Path;

use super::DetectArgs;
use crate::cli::error::{CliError, DetectError};
use crate::cli::recorded;
use trocar_sim::scenario::{ScenarioError, Source, Values};

/// The end of the name of a file of labels beside its recording.
pub(super) const SIDECAR_END: &str = ".labels.csv";

/// What stands beside the recordings' folders.
const TAKEN: [&str; 7] =
    ["report.html", "detections.json", "events.csv", "timeline.svg", "timeline.png", "delays.svg", "delays.png"];

/// A recording to be read.
#[derive(Debug)]
pub(super) struct Input {
    /// As the user named it; of a folder, its path within that.
    pub(super) given: String,
    /// The folder of its files, unlike that of any other.
    pub(super) folder: String,
    /// What is known of it before it is read.
    pub(super) values: Result<Values, ScenarioError>,
}

impl Input {
    /// Whether it is the recording that a scenario file names.
    pub(super) fn is_scenario(&self) -> bool {
        recorded::is_scenario(&self.given)
    }
}

/// The recordings that the arguments name, in their order.
pub(super) fn inputs(args: &DetectArgs) -> Result<Vec<Input>, CliError> {
    let mut given = vec![];
    for recording in &args.recordings {
        if Path::new(recording).is_dir() {
            given.extend(listed(recording)?);
        } else {
            given.push(recording.clone());
        }
    }
    let load = |given: &String| recorded::load(given, &args.settings(Some(given)));
    let values: Vec<_> = given.iter().map(load).collect();
    let names: Vec<String> = given
        .iter()
        .zip(&values)
        .map(|(given, values)| {
            values.as_ref().map_or_else(|_| Source::parse(given).stem(), |values| values.name().to_owned())
        })
        .collect();
    let folders = distinct(&names);
    let one = |((given, folder), values)| Input { given, folder, values };
    Ok(given.into_iter().zip(folders).zip(values).map(one).collect())
}

/// The CSV files of a folder by name, but for those of labels.
fn listed(folder: &str) -> Result<Vec<String>, CliError> {
    let refuse = |source| DetectError::Folder { path: folder.to_owned(), source };
    let mut found = vec![];
    for entry in std::fs::read_dir(folder).map_err(refuse)? {
        let path = entry.map_err(refuse)?.path();
        let name = path.file_name().unwrap_or_default().to_string_lossy().to_lowercase();
        if name.ends_with(".csv") && !name.ends_with(SIDECAR_END) && path.is_file() {
            found.push(path.to_string_lossy().into_owned());
        }
    }
    if found.is_empty() {
        return Err(DetectError::EmptyFolder { path: folder.to_owned() }.into());
    }
    found.sort();
    Ok(found)
}

/// The same names, the second `x` made `x-2` and so on, none in the way of another whatever the case of its letters.
fn distinct(names: &[String]) -> Vec<String> {
    let wanted: HashSet<String> = names.iter().map(|name| name.to_lowercase()).collect();
    let mut used: HashSet<String> = TAKEN.map(str::to_owned).into();
    let mut free = |name: &String| {
        if used.insert(name.to_lowercase()) {
            return name.clone();
        }
        let mut next = (2_u64..).map(|number| format!("{name}-{number}"));
        let own = next.find(|other| {
            let other = other.to_lowercase();
            !wanted.contains(&other) && used.insert(other)
        });
        own.unwrap_or_else(|| name.clone())
    };
    names.iter().map(&mut free).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_that_collide_are_told_apart() {
        let names = ["x", "y", "x", "X", "x-2", "events.csv", "x"].map(str::to_owned);
        assert_eq!(distinct(&names), ["x", "y", "x-3", "X-4", "x-2", "events.csv-2", "x-5"]);
    }
}
