mod files;
mod help;
mod inputs;
mod labels;
mod list;
mod rows;
mod source;
mod stream;
mod warnings;

use std::path::PathBuf;

use clap::Args;

use super::error::Failure;
use super::format::FormatArgs;
use super::quantity::quantity;
use super::recorded::{ColumnArgs, RecordedFlags};
use super::within::WithinArgs;
use super::{OutputArgs, ScenarioArgs, report};
use trocar_core::error::{non_negative, positive};
use trocar_metrics::RUPTURE_WINDOW_S;
use trocar_report::html::command_line;
use trocar_scenario::{Source, Values};

/// The argument that stands for standard input.
const STREAM: &str = "-";

/// Sections of its file that `--settings` reads.
const TUNED_SECTIONS: [&str; 2] = ["estimator", "detector"];

/// Run the estimator and the detector on recordings or on a live stream.
#[derive(Debug, Args)]
#[command(after_long_help = help::MORE, mut_arg("out", |arg| arg.help(super::OUT_PER_RECORDING)), mut_arg("settings", |arg| arg.help(super::SET_ONE)), mut_arg("within_s", |arg| arg.default_value(RUPTURE_WINDOW_S.to_string())))]
pub(super) struct DetectArgs {
    /// Recordings (CSV, .mat, NumPy, Parquet, MCAP, TDMS, HDF5, Excel, JSON lines), folders with recordings, builtin:own_ctrl_pop.csv,
    /// builtin:in_vivo_like.csv, or scenario files with a [recording]; or - for a live stream on standard input
    #[arg(required = true, value_name = "RECORDING")]
    recordings: Vec<String>,
    /// List the signals of the recordings: name, size, unit, rate, range and role, and a command line for them;
    /// detect nothing
    #[arg(long)]
    list: bool,
    #[command(flatten)]
    columns: ColumnArgs,
    /// Contact position, in m [default: 0]
    #[arg(long, value_name = "M", value_parser = quantity("m"), allow_hyphen_values = true)]
    contact_m: Option<f64>,
    /// A true rupture of a single recording, in s after the first sample, for scores (repeatable)
    #[arg(long = "rupture-s", value_name = "S", conflicts_with = "labels", value_parser = quantity("s"), allow_hyphen_values = true)]
    ruptures_s: Vec<f64>,
    /// True ruptures of many recordings: CSV with the columns file,time_s[,kind]
    #[arg(long, value_name = "FILE")]
    labels: Option<PathBuf>,
    #[command(flatten)]
    within: WithinArgs,
    /// Live stream: time between two samples, in s [default: the time between the first two samples]
    #[arg(long, value_name = "S", value_parser = quantity("s"), allow_hyphen_values = true)]
    interval_s: Option<f64>,
    /// Live stream: also print every Nth sample with its estimates
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    every: Option<u64>,
    /// Read [estimator] and [detector] from a file, such as calibrated.toml of `trocar calibrate`; flags and --set
    /// have priority
    #[arg(long = "settings", value_name = "FILE")]
    settings_file: Option<String>,
    /// The settings of that file.
    #[arg(skip)]
    tuning: Vec<String>,
    /// Also write report.html into the folder of each recording, and for many recordings a summary of all into DIR/detect:
    /// self-contained pages with tables, events and interactive charts
    #[arg(long)]
    report: bool,
    #[command(flatten)]
    format: FormatArgs,
    #[command(flatten)]
    changes: ScenarioArgs,
    #[command(flatten)]
    output: OutputArgs,
}

pub(super) fn run(mut args: DetectArgs) -> Result<(), Failure> {
    if let Some(file) = &args.settings_file {
        args.tuning = tuning(file)?;
    }
    let args = &args;
    non_negative("--within-s", args.within.within_s)?;
    if let Some(interval_s) = args.interval_s {
        positive("--interval-s", interval_s)?;
    }
    if args.recordings.iter().any(|recording| recording == STREAM) {
        if args.recordings.len() > 1 {
            return Err(Failure::input(
                "- reads a live stream from standard input; it cannot be combined with recordings",
            ));
        }
        let recordings_only = [
            ("--labels", args.labels.is_some()),
            ("--rupture-s", !args.ruptures_s.is_empty()),
            ("--report", args.report),
            ("--list", args.list),
        ];
        for (flag, given) in recordings_only.into_iter().chain(args.columns.of_files()) {
            if given {
                return Err(Failure::input(format!(
                    "{flag} is for recordings, not for a live stream; write the stream to a file and detect in that file"
                )));
            }
        }
        return stream::run(args);
    }
    for (flag, given) in [("--interval-s", args.interval_s.is_some()), ("--every", args.every.is_some())] {
        if given {
            return Err(Failure::input(format!("{flag} is for a live stream: trocar detect -")));
        }
    }
    if args.list { list::run(args) } else { files::run(args) }
}

/// A file with neither section is an error.
fn tuning(file: &str) -> Result<Vec<String>, Failure> {
    let values = Values::load(&Source::parse(file), &[])?;
    if TUNED_SECTIONS.iter().all(|section| values.section_place(section).is_none()) {
        return Err(Failure::input(format!(
            "{file} has neither [estimator] nor [detector]; give a file that has them, such as calibrated.toml of trocar \
             calibrate"
        )));
    }
    Ok(values.written_settings(&TUNED_SECTIONS))
}

impl DetectArgs {
    /// Returns the flags as settings, with the path of the recording if given. `--set` comes last and so has
    /// priority.
    fn settings(&self, recording: Option<&str>) -> Vec<String> {
        self.flags().settings(recording, &self.tuning)
    }

    fn flags(&self) -> RecordedFlags<'_> {
        RecordedFlags {
            columns: &self.columns,
            contact_m: self.contact_m,
            ruptures_s: &self.ruptures_s,
            changes: &self.changes,
        }
    }

    fn line(&self, recordings: &[String]) -> String {
        let mut words = vec!["detect".to_owned()];
        words.extend(recordings.iter().map(|recording| report::shown(recording)));
        words.extend(self.columns.flags());
        words.extend(self.contact_m.iter().flat_map(|contact_m| ["--contact-m".to_owned(), format!("{contact_m:?}")]));
        words.extend(self.ruptures_s.iter().flat_map(|rupture_s| ["--rupture-s".to_owned(), format!("{rupture_s:?}")]));
        let labels = self.labels.iter().map(|file| report::shown(&file.to_string_lossy()));
        words.extend(labels.flat_map(|file| ["--labels".to_owned(), file]));
        if self.within.within_s != RUPTURE_WINDOW_S {
            words.extend(["--within-s".to_owned(), format!("{:?}", self.within.within_s)]);
        }
        words.extend(self.settings_file.iter().flat_map(|file| ["--settings".to_owned(), report::shown(file)]));
        words.extend(report::set_flags(&self.changes.settings));
        words.extend(self.format.flags());
        words.push("--report".to_owned());
        command_line(words)
    }
}
