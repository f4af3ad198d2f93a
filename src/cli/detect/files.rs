use std::path::Path;

use rayon::prelude::*;

use super::DetectArgs;
use super::inputs::{Input, inputs};
use super::labels::{self, LabelRows};
use crate::cli::error::{Failure, Kind};
use crate::cli::finish::Finish;
use crate::cli::format::LONG_ROWS;
use crate::cli::warnings::Warnings;
use crate::cli::{progress, recorded, terminal};
use trocar_base::warning::Warning;
use trocar_detect::document::{DetectionEntry, DetectionStudy, Detections};
use trocar_detect::{DetectionReport, Label, detect};
use trocar_document::Study as _;
use trocar_report::html::Again;
use trocar_report::{ColumnFormat, Destination, Folder};
use trocar_scenario::{DetectionSpec, Reader, Values};

const SETTINGS: [&str; 6] = ["", "recording", "recording.columns", "recording.scale", "estimator", "detector"];

pub(super) fn run(args: &DetectArgs) -> Result<(), Failure> {
    if is_collection(args) {
        // Check the flags first, so that an invalid flag is reported once and not for each recording.
        Values::from_settings("recording", &args.settings(None)).map_err(recorded::of_flags)?;
    }
    let inputs = inputs(args)?;
    args.flags().check_ruptures(inputs.len())?;
    let labels = labels::given(args, &inputs)?;
    let work: Vec<_> = inputs.into_iter().zip(labels).collect();
    let out = Destination { samples: args.format.formats().to_vec(), ..args.output.destination() };
    if is_collection(args) {
        return many(args, &out, work);
    }
    work.into_iter().try_for_each(|(input, labels)| single(args, &out, input, labels))
}

/// A folder counts as many, even with a single file.
fn is_collection(args: &DetectArgs) -> bool {
    args.recordings.len() > 1 || args.recordings.iter().any(|recording| Path::new(recording).is_dir())
}

fn single(args: &DetectArgs, out: &Destination, input: Input, labels: Option<LabelRows>) -> Result<(), Failure> {
    let folder = out.open("detect", &folder_of(&input))?;
    let study = one(args, input, labels)?;
    let document = study.document();
    let warnings = Warnings::new(&args.output);
    warn(&warnings, &study.file, &document.warnings);
    let finish = finish(args, folder, &study);
    finish.document(&document)?;
    if !args.output.quiet && !args.output.json {
        terminal::print(&long_files(&finish.folder, study.report.samples))?;
    }
    warnings.finish()
}

/// Returns a line per long file.
fn long_files(folder: &Folder, rows: usize) -> String {
    if rows <= LONG_ROWS {
        return String::new();
    }
    let size = |format: &ColumnFormat| {
        let path = folder.path.join(format!("detection.{format}"));
        let bytes = std::fs::metadata(&path).ok()?.len();
        Some(format!("{}: {rows} rows, {:.1} MB\n", path.display(), bytes as f64 / 1e6))
    };
    folder.samples.iter().filter_map(size).collect()
}

fn many(args: &DetectArgs, out: &Destination, work: Vec<(Input, Option<LabelRows>)>) -> Result<(), Failure> {
    let out = out.open("detect", "detect")?;
    let bar = progress::bar(work.len(), args.output.quiet);
    bar.set_message("detecting");
    let of = |(input, labels): (Input, Option<LabelRows>)| {
        let (file, name, folder) = (input.given.clone(), input.folder.clone(), out.folder(&folder_of(&input)));
        let detected = one(args, input, labels).and_then(|study| {
            let document = study.document();
            finish(args, folder, &study).write(&document)?;
            let json = document.json;
            Ok((study.report, json))
        });
        bar.inc(1);
        (file, name, detected)
    };
    // Collecting keeps the order of the arguments, whatever the threads do.
    let outcomes: Vec<_> = work.into_par_iter().map(of).collect();
    bar.finish_and_clear();

    // True if all failures come from invalid input.
    let (mut failed, mut input_at_fault) = (0, true);
    let mut entries = vec![];
    let warnings = Warnings::new(&args.output);
    for (file, name, detected) in outcomes {
        if let Ok((report, _)) = &detected {
            warn(&warnings, &file, &report.warnings);
        }
        let outcome = detected.map_err(|error| {
            failed += 1;
            input_at_fault &= error.kind == Kind::Input;
            error.print(Some(&file));
            error.to_string()
        });
        entries.push(DetectionEntry { file, name, outcome });
    }
    let detections = Detections { entries };
    let again = args.report.then(|| again(args, vec![], &args.recordings));
    Finish { output: &args.output, folder: out, all: false, report: again }.document(&detections.document())?;
    if failed > 0 {
        // Their errors are already printed.
        let recordings = detections.entries.len();
        let message = format!("{failed} of {recordings} recordings failed, see above; the others are complete");
        return Err(if input_at_fault { Failure::input(message) } else { Failure::work(message) });
    }
    warnings.finish()
}

fn again(args: &DetectArgs, files: Vec<(String, String)>, recordings: &[String]) -> Again {
    let note = "Run this command in the folder of the recordings.";
    Again { command: "trocar detect", files, line: args.line(recordings), note }
}

fn finish<'a>(args: &'a DetectArgs, folder: Folder, study: &DetectionStudy) -> Finish<'a> {
    let folder = folder.with_samples(args.format.of_rows(study.report.samples).to_vec());
    let name = study.values.name();
    let settings = || vec![(format!("{name}.toml"), study.values.sections_toml(SETTINGS))];
    let report = args.report.then(|| again(args, settings(), std::slice::from_ref(&study.file)));
    Finish { output: &args.output, folder, all: false, report }
}

fn folder_of(input: &Input) -> String {
    // Keeps the summary and the figures of a run of the same scenario.
    if input.is_scenario() { format!("{}/detection", input.folder) } else { input.folder.clone() }
}

fn one(args: &DetectArgs, input: Input, labels: Option<LabelRows>) -> Result<DetectionStudy, Failure> {
    let Input { given, folder: name, values, guess } = input;
    let mut values = values?.with_adaptive_detector();
    let spec = DetectionSpec::resolve(&mut values).map_err(recorded::placed(&given))?;
    let detection = detect(&spec)?;
    let labels = labels_of(&given, &spec, labels)?;
    let mut report = DetectionReport::judged(&detection, labels.as_deref(), args.within.within_s);
    let unread = args.flags().unread(&values, Reader::Detection);
    report.warnings.splice(0..0, guess.into_iter().chain(unread));
    let mut study = DetectionStudy::new(name, given, values, (detection, report));
    study.is_drawn = args.report || !args.output.no_figures;
    Ok(study)
}

fn warn(warnings: &Warnings, given: &str, of_recording: &[Warning]) {
    warnings.print(&of_recording.iter().map(|warning| warning.clone().of(given)).collect::<Vec<_>>());
}

/// From `--labels`, else the scenario or `--rupture-s`, else the label file in the recording's folder.
fn labels_of(given: &str, spec: &DetectionSpec, rows: Option<LabelRows>) -> Result<Option<Vec<Label>>, Failure> {
    let time_s = spec.recording.recording.time_s();
    let from_s = time_s.first().copied().unwrap_or(0.0);
    let to_s = time_s.last().copied().unwrap_or(0.0);
    let own = &spec.recording.ruptures_s;
    if rows.is_none() && !own.is_empty() {
        return Ok(Some(own.iter().map(|rupture| Label { time_s: from_s + rupture, kind: None }).collect()));
    }
    let rows = match rows {
        None => labels::from_sidecar(given)?,
        rows => rows,
    };
    rows.map(|rows| rows.labels(from_s, to_s, spec.recording.recording.origin_s())).transpose()
}
