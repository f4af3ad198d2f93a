//! Detection in one or many recordings.

use std::path::Path;

use rayon::prelude::*;
use serde_json::Value as Json;

use super::DetectArgs;
use super::inputs::{Input, inputs};
use super::labels::{self, LabelRows};
use crate::cli::error::{CliError, DetectError};
use crate::cli::warnings::Warnings;
use crate::cli::{progress, recorded, report as page, terminal};
use trocar_base::warning::Warning;
use trocar_detect::{Detection, DetectionReport, Label, detect};
use trocar_report::html::{DetectionPage, detection_html, detections_html};
use trocar_report::{
    DetectionEntry, EVENT_COLUMNS, Folder, detection_object, detection_pictures, detection_text, detections_json,
    detections_pictures, detections_text, event_rows, to_json, write_detection,
};
use trocar_scenario::{DetectionSpec, Values};

/// The sections of a scenario that affect a detection.
const SETTINGS: [&str; 6] = ["", "recording", "recording.columns", "recording.scale", "estimator", "detector"];

/// The result of one recording.
struct Detected {
    report: DetectionReport,
    json: Json,
}

pub(super) fn run(args: &DetectArgs) -> Result<(), CliError> {
    if is_collection(args) {
        // An invalid flag is reported once, not for each recording.
        Values::from_settings("recording", &args.settings(None)).map_err(recorded::of_flags)?;
    }
    let inputs = inputs(args)?;
    if !args.ruptures_s.is_empty() && inputs.len() > 1 {
        return Err(DetectError::RupturesOfMany { recordings: inputs.len() }.into());
    }
    let labels = labels::given(args, &inputs)?;
    let work: Vec<_> = inputs.into_iter().zip(labels).collect();
    let out = args.output.folder();
    if is_collection(args) {
        return many(args, &out, work);
    }
    work.into_iter().try_for_each(|(input, labels)| single(args, &out, input, labels))
}

/// Returns whether the output has the format of many recordings. A folder is a collection, even with a single file.
fn is_collection(args: &DetectArgs) -> bool {
    args.recordings.len() > 1 || args.recordings.iter().any(|recording| Path::new(recording).is_dir())
}

fn single(args: &DetectArgs, out: &Folder, input: Input, labels: Option<LabelRows>) -> Result<(), CliError> {
    let folder = folder_of(out, &input);
    let name = input.folder.clone();
    let given = input.given.clone();
    let detected = one(args, &folder, input, labels)?;
    let warnings = Warnings::new(&args.output);
    warn(&warnings, &given, &detected);
    if args.output.json {
        terminal::print(&to_json(&detected.json))?;
    } else if !args.output.quiet {
        let written = folder.path().display();
        terminal::print(&format!("{}files: {written}\n", detection_text(&name, &detected.report)))?;
        if args.report {
            page::print_path(&folder)?;
        }
    }
    warnings.finish()
}

fn many(args: &DetectArgs, out: &Folder, work: Vec<(Input, Option<LabelRows>)>) -> Result<(), CliError> {
    let bar = progress::bar(work.len(), args.output.quiet);
    bar.set_message("detecting");
    let of = |(input, labels): (Input, Option<LabelRows>)| {
        let (file, name) = (input.given.clone(), input.folder.clone());
        let detected = one(args, &folder_of(out, &input), input, labels);
        bar.inc(1);
        (file, name, detected)
    };
    // The outcomes have the order of the arguments, independent of the threads.
    let outcomes: Vec<_> = work.into_par_iter().map(of).collect();
    bar.finish_and_clear();

    let (mut failed, mut input_at_fault) = (0, true);
    let mut entries = vec![];
    let warnings = Warnings::new(&args.output);
    for (file, name, detected) in outcomes {
        if let Ok(detected) = &detected {
            warn(&warnings, &file, detected);
        }
        let outcome = detected.map(|detected| (detected.report, detected.json)).map_err(|error| {
            failed += 1;
            input_at_fault &= error.is_input();
            error.print(Some(&file));
            error.to_string()
        });
        entries.push(DetectionEntry { file, name, outcome });
    }
    let json = detections_json(&entries);
    write_joint(args, out, &entries, &json)?;
    if args.output.json {
        terminal::print(&json)?;
    } else if !args.output.quiet {
        terminal::print(&format!("{}files: {}\n", detections_text(&entries), out.path().display()))?;
        if args.report {
            page::print_path(out)?;
        }
    }
    if failed > 0 {
        return Err(DetectError::Some { failed, recordings: entries.len(), input_at_fault }.into());
    }
    warnings.finish()
}

/// Writes the common files of all recordings.
fn write_joint(args: &DetectArgs, out: &Folder, entries: &[DetectionEntry], json: &str) -> Result<(), CliError> {
    let reports: Vec<_> =
        entries.iter().filter_map(|entry| entry.outcome.as_ref().ok().map(|(report, _)| (entry, report))).collect();
    out.write("detections.json", json.as_bytes())?;
    let mut events = format!("{EVENT_COLUMNS}\n");
    events.extend(reports.iter().map(|(entry, report)| event_rows(&entry.file, report)));
    out.write("events.csv", events.as_bytes())?;
    if args.report {
        out.write(page::FILE, detections_html(entries, &args.line(&args.recordings))?.as_bytes())?;
    }
    if !args.no_figures {
        let named: Vec<_> = reports.iter().map(|(entry, report)| (entry.name.as_str(), *report)).collect();
        detections_pictures(out, &named)?;
    }
    Ok(())
}

fn folder_of(out: &Folder, input: &Input) -> Folder {
    let folder = out.folder(&input.folder);
    // A separate folder keeps the summary and figures of a run of the same scenario.
    if input.is_scenario() { folder.folder("detection") } else { folder }
}

/// Detects in one recording and writes its files.
fn one(args: &DetectArgs, folder: &Folder, input: Input, labels: Option<LabelRows>) -> Result<Detected, CliError> {
    let Input { given, folder: name, values, guess } = input;
    let mut values = values?.with_adaptive_detector();
    let spec = DetectionSpec::resolve(&mut values).map_err(recorded::placed(&given))?;
    let detection = detect(&spec)?;
    let labels = labels_of(&given, &spec, labels)?;
    let mut report = DetectionReport::judged(&detection, labels.as_deref(), args.window_s);
    report.warnings.splice(0..0, guess);
    let json = detection_object(&name, &report, &values);
    write(args, folder, &given, &spec, (&values, &detection, &report), &json)?;
    Ok(Detected { report, json })
}

/// Prints the warnings about a recording.
fn warn(warnings: &Warnings, given: &str, detected: &Detected) {
    let of = |warning: &Warning| warning.clone().of(given);
    warnings.print(&detected.report.warnings.iter().map(of).collect::<Vec<_>>());
}

/// Returns the labels of a recording: from `--labels`, or from its scenario or `--rupture-s`, or from the label file in the same
/// folder.
fn labels_of(given: &str, spec: &DetectionSpec, rows: Option<LabelRows>) -> Result<Option<Vec<Label>>, CliError> {
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
    Ok(rows.map(|rows| rows.labels(from_s, to_s)).transpose()?)
}

fn write(
    args: &DetectArgs,
    folder: &Folder,
    given: &str,
    spec: &DetectionSpec,
    (values, detection, report): (&Values, &Detection, &DetectionReport),
    json: &Json,
) -> Result<(), CliError> {
    let detector = &spec.settings.detector;
    let files = || -> Result<(), CliError> {
        args.format.write(folder, "detection", |format, out| write_detection(detection, format, out))?;
        folder.write("detection.json", to_json(json).as_bytes())?;
        folder.write("events.csv", format!("{EVENT_COLUMNS}\n{}", event_rows(given, report)).as_bytes())?;
        Ok(())
    };
    if args.report {
        let page = DetectionPage {
            name: values.name(),
            detection,
            report,
            scale: (detector.cusum.threshold, detector.distance.kind.unit()),
            settings: &values.sections_toml(SETTINGS),
            line: &args.line(&[given.to_owned()]),
        };
        folder.write(page::FILE, detection_html(&page)?.as_bytes())?;
    }
    if args.no_figures {
        return files();
    }
    let pictures = || {
        let scale = (detector.cusum.threshold, detector.distance.kind.unit());
        detection_pictures(folder, values.name(), detection, report, scale)
    };
    let (files, pictures) = rayon::join(files, pictures);
    files?;
    pictures?;
    Ok(())
}
