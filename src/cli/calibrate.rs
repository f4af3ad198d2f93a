use clap::Args;

use super::error::Failure;
use super::finish::Finish;
use super::quantity::quantity;
use super::recorded::{ColumnArgs, RecordedFlags};
use super::warnings::Warnings;
use super::{OutputArgs, ScenarioArgs, progress, recorded, terminal};
use trocar_detect::calibration::{CalibrationRequest, CalibrationStudy, RunLength, calibrate, run_lengths_document};
use trocar_detect::detect;
use trocar_document::Study as _;
use trocar_report::document_text;
use trocar_scenario::{DetectionSpec, Reader};

/// Compute settings of estimator and detector from the beginning of a recording.
#[derive(Debug, Args)]
#[command(after_long_help = MORE, mut_arg("out", |arg| arg.help(super::OUT_PER_RECORDING)), mut_arg("settings", |arg| arg.help(super::SET_ONE)))]
pub(super) struct CalibrateArgs {
    /// A recording (CSV, .mat, Parquet, TDMS, HDF5, Excel), builtin:own_ctrl_pop.csv, builtin:in_vivo_like.csv, or a
    /// scenario file with a [recording]; required unless --run-lengths is given
    #[arg(value_name = "RECORDING", required_unless_present = "run_lengths")]
    recording: Option<String>,
    #[command(flatten)]
    columns: ColumnArgs,
    /// Contact position, in m [default: computed]
    #[arg(long, value_name = "M", value_parser = quantity("m"), allow_hyphen_values = true)]
    contact_m: Option<f64>,
    /// A true rupture, in s after the first sample, to be excluded from the quiet segment (repeatable)
    #[arg(long = "rupture-s", value_name = "S", value_parser = quantity("s"), allow_hyphen_values = true)]
    ruptures_s: Vec<f64>,
    /// Length of the analysed part, from the beginning of the recording, in s
    #[arg(long, value_name = "S", default_value_t = CalibrationRequest::default().first_s, value_parser = quantity("s"), allow_hyphen_values = true)]
    first_s: f64,
    /// The quiet segment, in s after the first sample, as in 1.5,4 [default: computed]
    #[arg(long, value_name = "FROM,TO", value_parser = segment, allow_hyphen_values = true)]
    quiet_s: Option<(f64, f64)>,
    /// Requested mean time between false alarms, in s; it must correspond to 2 to 1e10 samples
    #[arg(long, value_name = "S", default_value_t = CalibrationRequest::default().false_alarm_s, value_parser = quantity("s"), allow_hyphen_values = true)]
    false_alarm_s: f64,
    /// Time in which the force of the slowest rupture falls by half, in s
    #[arg(long, value_name = "S", default_value_t = CalibrationRequest::default().slowest_rupture_s, value_parser = quantity("s"), allow_hyphen_values = true)]
    slowest_rupture_s: f64,
    /// Time in which the force of the fastest harmless change falls by half, in s
    #[arg(long, value_name = "S", default_value_t = CalibrationRequest::default().fastest_harmless_s, value_parser = quantity("s"), allow_hyphen_values = true)]
    fastest_harmless_s: f64,
    /// Ratio of the residual's variance at a rupture to its quiet variance; determines the drift
    #[arg(long, value_name = "RATIO", default_value_t = CalibrationRequest::default().variance_ratio, allow_negative_numbers = true)]
    variance_ratio: f64,
    /// Print predicted and simulated run lengths from 1e3 to 1e7 samples, instead of a calibration
    #[arg(long, conflicts_with = "recording")]
    run_lengths: bool,
    #[command(flatten)]
    changes: ScenarioArgs,
    #[command(flatten)]
    output: OutputArgs,
}

const MORE: &str = "\
Method:
  noise      from second differences of the force; the dead zone is twice the
             noise
  contact    position at which the force rises above its noise, or at which a
             line through force and position is zero
  quiet      blocks of 0.1 s in contact without a rupture; sigma_0 is the 90 %
             quantile of their RMS values
  drift      residual at which the log-likelihood ratio of eq. 23 changes sign,
             for a variance 100 times larger (--variance-ratio)
  threshold  from the requested average run length to a false alarm (Page's
             integral equation), and at least twice the largest harmless
             excursion in the segment
  memory     slow ruptures and fast harmless changes are inserted into the
             recording; the memory that separates them best

Files, in a folder with the name of the recording in --out: calibrated.toml, an input of `trocar detect` and of its \
--settings; calibration.json; in the subfolder calibration, figures of the whole recording with these settings.

Examples:
  trocar calibrate force.csv --time t_s --position x_mm:1e-3 --force f_n
  trocar detect out/force/calibrated.toml
  trocar detect others/ --settings out/force/calibrated.toml --time t_s \\
      --position x_mm:1e-3 --force f_n";

/// Mean run lengths in samples, each with its number of runs.
const RUN_LENGTHS: [(f64, u64); 5] = [(1e3, 4096), (1e4, 4096), (1e5, 4096), (1e6, 2048), (1e7, 1024)];

fn segment(text: &str) -> Result<(f64, f64), String> {
    let number = quantity("s");
    let (from, to) = text.split_once(',').ok_or("must be two times in s, as in 1.5,4")?;
    let (from, to) = (number(from)?, number(to)?);
    if from < to { Ok((from, to)) } else { Err(format!("{from} s is not before {to} s; write the earlier time first")) }
}

pub(super) fn run(args: &CalibrateArgs) -> Result<(), Failure> {
    let Some(recording) = &args.recording else { return run_lengths(args) };
    let flags = RecordedFlags {
        columns: &args.columns,
        contact_m: args.contact_m,
        ruptures_s: &args.ruptures_s,
        changes: &args.changes,
    };
    let (mut values, guess) = recorded::load_guessed(recording, &flags, &[])?;
    let keeps_contact = values.place("estimator.contact_m").is_some();
    let spec = DetectionSpec::resolve(&mut values).map_err(recorded::placed(recording))?;
    let request = CalibrationRequest {
        first_s: args.first_s,
        quiet_s: args.quiet_s,
        keeps_contact,
        false_alarm_s: args.false_alarm_s,
        slowest_rupture_s: args.slowest_rupture_s,
        fastest_harmless_s: args.fastest_harmless_s,
        variance_ratio: args.variance_ratio,
    };
    let folder = args.output.destination().open("calibrate", values.name())?;
    let calibration = calibrate(&spec, &request)?;
    let chosen = calibration.rounded_settings();
    let mut calibrated = spec;
    let settings = &mut calibrated.settings;
    (settings.estimator, settings.detector, settings.contact_m) = (chosen.estimator, chosen.detector, chosen.contact_m);
    let inputs = values.sections_toml(["", "recording", "recording.columns", "recording.scale", "sensor"]);
    let detected = (detect(&calibrated)?, &*calibrated.recording.ruptures_s);
    let study = CalibrationStudy::new(values.name(), &calibration, inputs, detected);
    let document = study.document();
    let warnings = Warnings::new(&args.output);
    let unread = flags.unread(&values, Reader::Calibration);
    let all = guess.into_iter().chain(unread).chain(document.warnings.iter().cloned());
    warnings.print(&all.map(|warning| warning.of(recording)).collect::<Vec<_>>());
    Finish { output: &args.output, folder, all: false, report: None }.document(&document)?;
    warnings.finish()
}

fn run_lengths(args: &CalibrateArgs) -> Result<(), Failure> {
    let request = CalibrationRequest { variance_ratio: args.variance_ratio, ..CalibrationRequest::default() };
    request.validate()?;
    let drift = request.drift();
    let samples = RUN_LENGTHS.map(|(length, alarms)| (length * alarms as f64 / 1e6) as usize);
    let bar = progress::bar(samples.iter().sum(), args.output.quiet);
    bar.set_message("simulating, million samples");
    let check = |(length, alarms): (f64, u64)| {
        RunLength::check(drift, length, alarms, || bar.inc((length * 32.0 / 1e6) as u64))
    };
    let lengths = RUN_LENGTHS.map(check);
    bar.finish_and_clear();
    if args.output.quiet { Ok(()) } else { terminal::print(&document_text(&run_lengths_document(&lengths), false)) }
}
