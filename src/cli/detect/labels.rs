use std::path::{Path, PathBuf};

use super::DetectArgs;
use super::inputs::{Input, SIDECAR_END};
use crate::cli::error::Failure;
use trocar_detect::Label;
use trocar_recording::{CALENDAR_S, Format, LabelRow, Limits, open_labels};

#[derive(Debug, Clone)]
pub(super) struct LabelRows {
    file: String,
    rows: Vec<LabelRow>,
}

/// `None` for a recording without rows.
pub(super) fn given(args: &DetectArgs, inputs: &[Input]) -> Result<Vec<Option<LabelRows>>, Failure> {
    let mut by_input: Vec<Option<LabelRows>> = inputs.iter().map(|_| None).collect();
    let Some(path) = &args.labels else { return Ok(by_input) };
    let file = path.display().to_string();
    let is_single = inputs.len() == 1;
    for row in open_labels(path, &Limits::default(), !is_single)? {
        let refuse = |problem: String| Failure::input(format!("{file} line {}: {problem}", row.line));
        // The labels of a single recording need no file name.
        let index = row.file.as_deref().map_or(Ok(0), |name| named(name, inputs).map_err(refuse))?;
        let labels = by_input[index].get_or_insert_with(|| LabelRows { file: file.clone(), rows: vec![] });
        labels.rows.push(row);
    }
    // With a single recording, a file without rows means that the recording has no rupture.
    if is_single && by_input[0].is_none() {
        by_input[0] = Some(LabelRows { file, rows: vec![] });
    }
    Ok(by_input)
}

/// The name is the path on the command line, or the file name if that is unique.
fn named(name: &str, inputs: &[Input]) -> Result<usize, String> {
    let last = |given: &str| Path::new(given).file_name().is_some_and(|own| own.to_string_lossy() == name);
    let builtin = |given: &str| given.strip_prefix("builtin:").is_some_and(|own| own == name);
    let exact: Vec<usize> = (0..inputs.len()).filter(|&index| inputs[index].given == name).collect();
    let same_file_name =
        || (0..inputs.len()).filter(|&i| last(&inputs[i].given) || builtin(&inputs[i].given)).collect();
    let found: Vec<usize> = if exact.is_empty() { same_file_name() } else { exact };
    match found.as_slice() {
        [] => Err(format!(
            "'{name}' is not one of the given recordings; name it as on the command line, or remove its labels"
        )),
        [index] => Ok(*index),
        [first, second, ..] => {
            let (first, second) = (&inputs[*first].given, &inputs[*second].given);
            Err(format!("'{name}' matches {first} and {second}; name it as on the command line"))
        }
    }
}

/// Rows of the label file in the recording's folder, if it exists.
pub(super) fn from_sidecar(recording: &str) -> Result<Option<LabelRows>, Failure> {
    let Some(path) = sidecar(recording).filter(|path| path.exists()) else { return Ok(None) };
    let rows = open_labels(&path, &Limits::default(), false)?;
    Ok(Some(LabelRows { file: path.display().to_string(), rows }))
}

fn sidecar(recording: &str) -> Option<PathBuf> {
    let (stem, end) = recording.rsplit_once('.')?;
    let end = end.to_lowercase();
    if !Format::ALL.iter().any(|format| format.suffixes().contains(&end.as_str())) {
        return None;
    }
    (!recording.starts_with("builtin:")).then(|| PathBuf::from(format!("{stem}{SIDECAR_END}")))
}

impl LabelRows {
    /// Sorted by time, from `from_s` to `to_s` (s). Labels of the calendar, in s since 1970, count from `origin_s`,
    /// like the times of the recording.
    pub(super) fn labels(&self, from_s: f64, to_s: f64, origin_s: f64) -> Result<Vec<Label>, Failure> {
        let refuse = |line: u64, problem: String| Err(Failure::input(format!("{} line {line}: {problem}", self.file)));
        let mut timed: Vec<(f64, &LabelRow)> = vec![];
        for row in &self.rows {
            let Some(time_s) = row.time_s else { continue };
            let time_s = if time_s.abs() >= CALENDAR_S { time_s - origin_s } else { time_s };
            if !(from_s..=to_s).contains(&time_s) {
                let problem = format!(
                    "the rupture at {time_s} s is outside the recording, which lasts from {from_s} to {to_s} s in its own \
                     time"
                );
                return refuse(row.line, problem);
            }
            timed.push((time_s, row));
        }
        if let (Some(none), Some((_, other))) = (self.rows.iter().find(|row| row.time_s.is_none()), timed.first()) {
            let problem = format!(
                "an empty time means that the recording has no rupture, but line {} labels one; remove one of the two",
                other.line
            );
            return refuse(none.line, problem);
        }
        timed.sort_by(|a, b| a.0.total_cmp(&b.0));
        if let Some(pair) = timed.windows(2).find(|pair| pair[0].0 == pair[1].0) {
            let (time_s, first_line) = (pair[0].0, pair[0].1.line);
            let problem = format!("the rupture at {time_s} s is already on line {first_line}; remove one");
            return refuse(pair[1].1.line, problem);
        }
        Ok(timed.into_iter().map(|(time_s, row)| Label { time_s, kind: row.kind.clone() }).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_of_the_calendar_count_from_the_origin_of_the_recording() {
        let row = |(time_s, line)| LabelRow { file: None, time_s: Some(time_s), kind: None, line };
        let rows = [(1767225602.5, 2), (3.0, 3)].map(row).into();
        let found = LabelRows { file: "labels.csv".into(), rows }.labels(0.0, 5.0, 1767225600.0).expect("valid");
        assert_eq!(found.iter().map(|label| label.time_s).collect::<Vec<_>>(), [2.5, 3.0]);
    }

    #[test]
    fn a_label_names_its_recording_by_the_given_path_or_by_a_unique_file_name() {
        let input = |given: &str| Input {
            given: given.to_owned(),
            folder: String::new(),
            values: trocar_scenario::Values::load(&trocar_scenario::Source::parse("paper/classical"), &[]),
            guess: None,
        };
        let inputs = ["a/x.csv", "b/x.csv", "b/y.csv", "builtin:punch"].map(input);
        let index = |name| named(name, &inputs).ok();
        assert_eq!(
            [index("a/x.csv"), index("b/x.csv"), index("y.csv"), index("punch")],
            [Some(0), Some(1), Some(2), Some(3)]
        );
        let problem = |name| named(name, &inputs).expect_err("no unique name");
        assert!(problem("x.csv").starts_with("'x.csv' matches a/x.csv and b/x.csv; "));
        assert!(problem("z.csv").starts_with("'z.csv' is not one of the given recordings; "));
    }

    #[test]
    fn a_label_file_beside_a_recording_has_the_name_of_the_recording() {
        let beside = |recording: &str| sidecar(recording).map(|path| path.display().to_string());
        assert_eq!(beside("a/x.csv"), Some(format!("a/x{SIDECAR_END}")));
        assert_eq!(beside("a/x.CSV"), Some(format!("a/x{SIDECAR_END}")));
        assert_eq!([beside("builtin:x.csv"), beside("a/x"), beside("a/x.toml")], [None, None, None]);
    }
}
