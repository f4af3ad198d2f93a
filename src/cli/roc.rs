use clap::Args;

use super::error::Failure;
use super::finish::Finish;
use super::quantity::quantity;
use super::recorded::{ColumnArgs, RecordedFlags};
use super::report::shown;
use super::warnings::Warnings;
use super::within::WithinArgs;
use super::{OutputArgs, ScenarioArgs, interrupt, progress, recorded};
use trocar_core::detector::DistanceKind;
use trocar_document::command_line;
use trocar_recording::InVivoLikeVariant;
use trocar_report::html::Again;
use trocar_scenario::{DetectionSpec, Reader, Scenario, Source, Values};
use trocar_studies::roc::{Signal, Study};

/// Default scenario, whose recording is evaluated.
const SHIPPED: &str = "paper/classical";

const EXAMPLES: &str = "\
Examples:
  trocar roc                                the shipped insertion in noise
  trocar roc --noise-std-n 0.01,0.025,0.05  several noise levels
  trocar roc --drop-n 0.5,1,2 --sharpness-s 0.01,0.045
                                            smaller and sharper ruptures
  trocar roc x.csv --time t --position x:mm --force f --rupture-s 1.8
                                            a recording with its rupture
  trocar roc layers/through-the-skin        a closed loop with layered tissue
  trocar roc --trials --seeds 2000          2000 synthetic recordings";

/// Compute operating characteristics of detectors.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES, mut_arg("out", |arg| arg.help(super::OUT_PER_COMMAND)), mut_arg("within_s", |arg| arg.default_value("0.010").value_parser(within)))]
pub(super) struct RocArgs {
    /// Recordings (CSV, .mat, Parquet, TDMS, HDF5, Excel), or scenario files: their [recording], or their closed loop
    /// if they have no recording [default: the shipped in-vivo-like insertion]
    #[arg(value_name = "SCENARIO|RECORDING")]
    signals: Vec<String>,
    /// Evaluate synthetic recordings instead: each seed draws rate, noise, motion, and layers or another material
    #[arg(long, conflicts_with_all = ["signals", "noise_std_n", "drop_n", "sharpness_s", "depth_m", "time", "position", "velocity", "force", "contact_m", "ruptures_s"])]
    trials: bool,
    #[command(flatten)]
    columns: ColumnArgs,
    /// Contact position, in m [default: 0]
    #[arg(long, value_name = "M", value_parser = quantity("m"), allow_hyphen_values = true)]
    contact_m: Option<f64>,
    /// A true rupture of a single recording, in s after the first sample (repeatable)
    #[arg(long = "rupture-s", value_name = "S", value_parser = quantity("s"), allow_hyphen_values = true)]
    ruptures_s: Vec<f64>,
    /// Number of noise seeds per condition; more seeds resolve lower false-alarm rates
    #[arg(long, value_name = "N", default_value_t = 1000, value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    seeds: u64,
    /// Standard deviations of the added white noise, in N; 0.025 N is the paper's variance of 6.25e-4 N²
    #[arg(long, value_name = "LIST", value_delimiter = ',', default_value = "0.025", allow_hyphen_values = true, value_parser = noise)]
    noise_std_n: Vec<f64>,
    /// Force drops of the ruptures of the synthetic insertion, in N; 1 N is hard to detect, the shipped drops are 5.3
    /// N and 3.2 N
    #[arg(long, value_name = "LIST", value_delimiter = ',', allow_hyphen_values = true, value_parser = drop)]
    drop_n: Vec<f64>,
    /// Time constants of the force drops of the synthetic insertion, in s; the shipped time constant is 0.045 s
    #[arg(long, value_name = "LIST", value_delimiter = ',', allow_hyphen_values = true, value_parser = sharpness)]
    sharpness_s: Vec<f64>,
    /// Depths of the first rupture of the synthetic insertion, in m; they scale positions, not forces; the shipped
    /// depth is 0.02705 m
    #[arg(long, value_name = "LIST", value_delimiter = ',', allow_hyphen_values = true, value_parser = depth)]
    depth_m: Vec<f64>,
    /// Detectors, named by their detector.distance [default: all]
    #[arg(long, value_name = "LIST", value_delimiter = ',', value_parser = clap::builder::PossibleValuesParser::new(DistanceKind::WORDS))]
    detectors: Vec<String>,
    /// Number of thresholds per detector, from 0.01 to 100 times its own threshold
    #[arg(long, value_name = "N", default_value_t = 24, value_parser = clap::value_parser!(u64).range(2..=1000))]
    thresholds: u64,
    /// Also write report.html: one self-contained page with the curves and the tables
    #[arg(long)]
    report: bool,
    #[command(flatten)]
    within: WithinArgs,
    #[command(flatten)]
    changes: ScenarioArgs,
    #[command(flatten)]
    output: OutputArgs,
}

pub(super) fn run(args: &RocArgs) -> Result<(), Failure> {
    let warnings = Warnings::new(&args.output);
    let study = Study {
        signals: signals(args, &warnings)?,
        noise_std_n: if args.trials { vec![0.0] } else { args.noise_std_n.clone() },
        seeds: args.seeds,
        thresholds: args.thresholds as usize,
        within_s: args.within.within_s,
    };
    let folder = args.output.destination().open("roc", "roc")?;
    let conditions = study.signals.len() * study.noise_std_n.len();
    let cases = usize::try_from(args.seeds).unwrap_or(usize::MAX).saturating_mul(conditions);
    let bar = progress::rated_bar(cases, args.output.quiet);
    bar.set_message("cases");
    let roc = study.run(interrupt::stop_flag(), &|| bar.inc(1));
    bar.finish_and_clear();
    let roc = roc?;
    if roc.cases == 0 {
        return Err(Failure::interrupted("nothing was written"));
    }
    let document = roc.document(args.seeds);
    warnings.print(&document.warnings);
    let again = || Again {
        command: "trocar roc",
        files: vec![],
        note: "Run this command in the folder of the files that it names.",
        line: command_line(std::env::args().skip(1).map(|word| shown(&word))),
    };
    let finish = Finish { output: &args.output, folder: folder.clone(), all: false, report: args.report.then(again) };
    finish.document(&document)?;
    if roc.cases < roc.cases_planned {
        let kept = format!("{} of {} cases are in {}", roc.cases, roc.cases_planned, folder.path.display());
        return Err(Failure::interrupted(&kept));
    }
    warnings.finish()
}

fn signals(args: &RocArgs, warnings: &Warnings) -> Result<Vec<Signal>, Failure> {
    let kinds: Vec<DistanceKind> = DistanceKind::ALL
        .into_iter()
        .filter(|kind| args.detectors.is_empty() || args.detectors.iter().any(|requested| requested == kind.word()))
        .collect();
    let flags = RecordedFlags {
        columns: &args.columns,
        contact_m: args.contact_m,
        ruptures_s: &args.ruptures_s,
        changes: &args.changes,
    };
    flags.check_ruptures(args.signals.len())?;
    let varied = !(args.drop_n.is_empty() && args.sharpness_s.is_empty() && args.depth_m.is_empty());
    if !args.signals.is_empty() {
        if varied {
            return Err(Failure::input(
                "--drop-n, --sharpness-s and --depth-m vary the synthetic insertion; remove them or the other signals",
            ));
        }
        return args.signals.iter().map(|path| signal(path, &flags, &kinds, warnings)).collect();
    }
    let mut values = Values::load(&Source::parse(SHIPPED), &flags.settings(None, &[]))?;
    let spec = DetectionSpec::resolve(&mut values)?;
    if args.trials {
        return Ok(vec![Signal::trials(&spec, &kinds)]);
    }
    if !varied {
        return Ok(vec![Signal::recorded("in_vivo_like".into(), &spec, &kinds)?]);
    }
    let mut signals = vec![];
    for drop_n in optional(&args.drop_n) {
        for fall_s in optional(&args.sharpness_s) {
            for depth_m in optional(&args.depth_m) {
                signals.push(Signal::synthetic(&spec, InVivoLikeVariant { drop_n, fall_s, depth_m }, &kinds)?);
            }
        }
    }
    Ok(signals)
}

fn signal(
    path: &str,
    flags: &RecordedFlags<'_>,
    kinds: &[DistanceKind],
    warnings: &Warnings,
) -> Result<Signal, Failure> {
    let (mut values, guess) = recorded::load_guessed(path, flags, &[])?;
    if !values.is_given("recording.file") {
        return Ok(Signal::closed_loop(Scenario::load(&Source::parse(path), &flags.settings(None, &[]))?, kinds)?);
    }
    let unread = flags.unread(&values, Reader::Roc);
    warnings.print(&guess.into_iter().chain(unread).map(|warning| warning.of(path)).collect::<Vec<_>>());
    let spec = DetectionSpec::resolve(&mut values).map_err(recorded::placed(path))?;
    Ok(Signal::recorded(values.name().to_owned(), &spec, kinds)?)
}

fn optional(list: &[f64]) -> Vec<Option<f64>> {
    if list.is_empty() { vec![None] } else { list.iter().copied().map(Some).collect() }
}

fn between(text: &str, (low, high): (f64, f64), unit: &'static str) -> Result<f64, String> {
    let value = quantity(unit)(text)?;
    if (low..=high).contains(&value) { Ok(value) } else { Err(format!("must be from {low} to {high} {unit}")) }
}

fn noise(text: &str) -> Result<f64, String> {
    between(text, Study::NOISE_STDS_N, "N")
}

fn drop(text: &str) -> Result<f64, String> {
    between(text, InVivoLikeVariant::DROPS_N, "N")
}

fn sharpness(text: &str) -> Result<f64, String> {
    between(text, InVivoLikeVariant::FALLS_S, "s")
}

fn depth(text: &str) -> Result<f64, String> {
    between(text, InVivoLikeVariant::DEPTHS_M, "m")
}

fn within(text: &str) -> Result<f64, String> {
    between(text, (0.0, trocar_metrics::RUPTURE_WINDOW_S), "s")
}
