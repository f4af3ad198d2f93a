use std::path::Path;

use super::DetectArgs;
use crate::cli::error::Failure;
use crate::cli::recorded;
use trocar_base::names::distinct;
use trocar_base::warning::Warning;
use trocar_recording::Format;
use trocar_scenario::{ScenarioError, Source, Values};

/// Suffix of a label file in the folder of its recording.
pub(super) const SIDECAR_END: &str = ".labels.csv";

/// File names used in the output folder.
const RESERVED: [&str; 9] = [
    "report.html",
    "detections.json",
    "events.csv",
    "timeline.svg",
    "timeline.png",
    "timeline.pdf",
    "delays.svg",
    "delays.png",
    "delays.pdf",
];

#[derive(Debug)]
pub(super) struct Input {
    /// As the user gave it, or within a given folder.
    pub(super) given: String,
    pub(super) folder: String,
    pub(super) values: Result<Values, ScenarioError>,
    pub(super) guess: Option<Warning>,
}

impl Input {
    /// Returns true if the recording belongs to a scenario file.
    pub(super) fn is_scenario(&self) -> bool {
        recorded::is_scenario(&self.given)
    }
}

/// In the order of the arguments. A folder is replaced by its files.
pub(super) fn given(args: &DetectArgs) -> Result<Vec<String>, Failure> {
    let mut given = vec![];
    for recording in &args.recordings {
        if Path::new(recording).is_dir() {
            given.extend(listed(recording, args.labels.as_deref())?);
        } else {
            given.push(recording.clone());
        }
    }
    Ok(given)
}

pub(super) fn inputs(args: &DetectArgs) -> Result<Vec<Input>, Failure> {
    let given = given(args)?;
    let flags = args.flags();
    let (values, guesses): (Vec<_>, Vec<_>) = given
        .iter()
        .map(|given| match recorded::load_guessed(given, &flags, &args.tuning) {
            Ok((values, guess)) => (Ok(values), guess),
            Err(error) => (Err(error), None),
        })
        .unzip();
    let names: Vec<String> = given
        .iter()
        .zip(&values)
        .map(|(given, values)| {
            values.as_ref().map_or_else(|_| Source::parse(given).stem(), |values| values.name().to_owned())
        })
        .collect();
    let folders = distinct(&names, &RESERVED);
    let one = |(((given, folder), values), guess)| Input { given, folder, values, guess };
    Ok(given.into_iter().zip(folders).zip(values).zip(guesses).map(one).collect())
}

/// The CSV files of a folder, sorted by name, or else the files of the other formats. Leaves out label files, also the
/// file of `--labels`.
fn listed(folder: &str, labels: Option<&Path>) -> Result<Vec<String>, Failure> {
    let refuse = |error: std::io::Error| Failure::input(format!("{folder}: cannot read the folder: {error}"));
    let labels = labels.and_then(|labels| labels.canonicalize().ok());
    let mut files = vec![];
    for entry in std::fs::read_dir(folder).map_err(refuse)? {
        let path = entry.map_err(refuse)?.path();
        let name = path.file_name().unwrap_or_default().to_string_lossy().to_lowercase();
        let is_labels = name.ends_with(SIDECAR_END) || (labels.is_some() && path.canonicalize().ok() == labels);
        if path.is_file() && !is_labels {
            files.push((name, path.to_string_lossy().into_owned()));
        }
    }
    let ending = |ends: &dyn Fn(&str) -> bool| -> Vec<String> {
        let ends = |name: &str| name.rsplit_once('.').is_some_and(|(_, end)| ends(end));
        files.iter().filter(|(name, _)| ends(name)).map(|(_, path)| path.clone()).collect()
    };
    let mut found = ending(&|end| end == "csv");
    if found.is_empty() {
        found = ending(&|end| Format::ALL.iter().any(|format| format.suffixes().contains(&end)));
    }
    if found.is_empty() {
        return Err(Failure::input(format!("{folder}: this folder has no *.csv file; name the recordings")));
    }
    found.sort();
    Ok(found)
}
