//! `trocar detect`.

use clap::Args;

use super::error::CliError;
use super::{OutputArgs, ScenarioArgs, terminal};
use crate::detect::{DetectionReport, detect};
use crate::recording::Column;
use crate::report::{Folder, detection_json, detection_pictures, detection_text, write_detection_csv};
use crate::scenario::{DetectionSpec, ScenarioError, Source, Values};

/// Run the estimator and the detector on a recording.
#[derive(Debug, Args)]
pub(super) struct DetectArgs {
    /// A CSV recording, builtin:own_ctrl_pop.csv, builtin:in_vivo_like.csv, or a scenario file whose [recording] to use
    #[arg(value_name = "RECORDING")]
    recording: String,
    /// Column with the time in s [default: time_s]
    #[arg(long, value_name = "COLUMN[:FACTOR]")]
    time: Option<Column>,
    /// Column with the needle's position in m [default: position_m]
    #[arg(long, value_name = "COLUMN[:FACTOR]", allow_hyphen_values = true)]
    position: Option<Column>,
    /// Column with its velocity in m/s; estimated from the position when not given
    #[arg(long, value_name = "COLUMN[:FACTOR]", allow_hyphen_values = true)]
    velocity: Option<Column>,
    /// Column with the force on it in N [default: force_n]
    #[arg(long, value_name = "COLUMN[:FACTOR]", allow_hyphen_values = true)]
    force: Option<Column>,
    /// Where the tissue begins, in m [default: 0]
    #[arg(long, value_name = "M", allow_negative_numbers = true)]
    contact_m: Option<f64>,
    /// A true rupture, in s after the first sample, to judge the alarms by (repeatable)
    #[arg(long = "rupture-s", value_name = "S")]
    ruptures_s: Vec<f64>,
    #[command(flatten)]
    changes: ScenarioArgs,
    #[command(flatten)]
    output: OutputArgs,
}

pub(super) fn run(args: &DetectArgs) -> Result<(), CliError> {
    let source = Source::parse(&args.recording);
    let settings = settings(args);
    let is_scenario = args.recording.ends_with(".toml");
    let mut values = if is_scenario {
        Values::load(&source, &settings)?
    } else {
        Values::from_settings(&source.stem(), &settings).map_err(|error| plain(error, false))?
    };
    let spec = DetectionSpec::resolve(&mut values).map_err(|error| plain(error, is_scenario))?;
    let name = values.name().to_owned();
    let detection = detect(&spec)?;
    let report = DetectionReport::of(&detection, &spec.recording.ruptures_s);
    let json = detection_json(&name, &report, &values);

    let mut folder = Folder::new(&args.output.out).folder(&name);
    if is_scenario {
        // Beside the run of the same scenario, whose summary and figures stay.
        folder = folder.folder("detection");
    }
    let detector = &spec.detector;
    let files = || -> Result<(), CliError> {
        folder.stream("detection.csv", |out| write_detection_csv(&detection, out))?;
        folder.write("detection.json", json.as_bytes())?;
        Ok(())
    };
    let pictures = || {
        let scale = (detector.cusum.threshold, detector.distance.kind.unit());
        detection_pictures(&folder, &name, &detection, &report, scale)
    };
    let (files, pictures) = rayon::join(files, pictures);
    files?;
    pictures?;
    if args.output.json {
        terminal::print(&json)
    } else if args.output.quiet {
        Ok(())
    } else {
        let written = folder.path().display();
        terminal::print(&format!("{}files: {written}\n", detection_text(&name, &report)))
    }
}

/// The flags as settings; those of --set come last and count.
fn settings(args: &DetectArgs) -> Vec<String> {
    let text = |text: &str| toml::Value::String(text.to_owned()).to_string();
    let mut settings = vec![];
    if !args.recording.ends_with(".toml") {
        settings.push(format!("recording.file={}", text(&args.recording)));
    }
    let columns = [
        ("time_s", &args.time, None),
        ("position_m", &args.position, Some("position_sign")),
        ("velocity_m_per_s", &args.velocity, Some("velocity_sign")),
        ("force_n", &args.force, Some("force_sign")),
    ];
    for (quantity, column, sign) in columns {
        let Some(column) = column else { continue };
        settings.push(format!("recording.columns.{quantity}={}", text(column.name())));
        let scale = if sign.is_some() { column.scale().abs() } else { column.scale() };
        settings.push(format!("recording.scale.{quantity}={scale:?}"));
        if let Some(sign) = sign {
            settings.push(format!("recording.{sign}={}", column.scale().signum()));
        }
    }
    if let Some(contact_m) = args.contact_m {
        settings.push(format!("estimator.contact_m={contact_m:?}"));
    }
    if !args.ruptures_s.is_empty() {
        settings.push(format!("recording.ruptures_s={:?}", args.ruptures_s));
    }
    settings.extend(args.changes.settings.iter().cloned());
    settings
}

/// Without a scenario file, the place of an error is a flag, which the message names better than a made-up line.
fn plain(mut error: ScenarioError, is_scenario: bool) -> ScenarioError {
    if !is_scenario {
        error.place = None;
    }
    error
}
