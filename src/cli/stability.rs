use std::io::Write as _;
use std::path::{Path, PathBuf};

use clap::Args;

use super::error::Failure;
use super::finish::Finish;
use super::warnings::Warnings;
use super::{OutputArgs, ScenarioArgs, interrupt, progress, terminal};
use trocar_document::Study as _;
use trocar_recording::{Limits, open_response};
use trocar_report::html::{Again, command_line};
use trocar_scenario::{Source, keys_outside_loop};
use trocar_stability::{Axis, FrequencyResponse, MeasuredSides, Parameter, Terminations};
use trocar_studies::stability_check::{
    MAX_STIFFNESS_N_PER_M, StabilityStudy, VerificationError, Verified, is_tissue, verify,
};

const DEFAULT_SCENARIO: &str = "paper/depth-classical";
const DEFAULT_X: &str = "scaling.force=0.1:10:200";
const DEFAULT_Y: &str = "tissue.stiffness_n_per_m=10:2000:200";
const DEFAULT_HAND: &str = "0:inf";

const MAX_DAMPING_N_S_PER_M: f64 = 1e6;

/// The options that --verify does not use.
const ANALYSIS: [&str; 21] = [
    "x",
    "y",
    "simulate",
    "tissue",
    "tissue_damping",
    "hand",
    "absolute",
    "locus",
    "z_width",
    "master_response",
    "slave_response",
    "arms",
    "event_limits",
    "report",
    "out",
    "quiet",
    "deny_warnings",
    "json",
    "no_figures",
    "figure_format",
    "figure_width",
];

const EXAMPLES: &str = "\
Examples:
  trocar stability                          force scale and stiffness
  trocar stability my.toml --set tissue.stiffness_n_per_m=400
                                            another tissue
  trocar stability my.toml --x channel.delay_s=0:0.1:100 \\
      --y scaling.force=0.1:10:100          delay and force scale
  trocar stability my.toml --z-width 0:50:100
                                            Z-width
  trocar stability my.toml --locus channel.delay_s=0:0.1:50
                                            poles over the delay
  trocar stability my.toml --arms 1000      limits over people
  trocar stability my.toml --absolute channel.delay_s=0:0.1:50 --hand 10:inf
                                            absolute stability over the delay
  trocar stability my.toml --slave-response slave.csv
                                            with a measured slave
  trocar stability my.toml --simulate       and compare with simulations
  trocar stability my.toml --verify out/my/certificate.json
                                            verify a certificate";

/// Analyse the stability of the loop.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES, mut_arg("settings", |arg| arg.help(super::SET_ONE)))]
pub(super) struct StabilityArgs {
    /// A scenario file, or a shipped scenario such as paper/classical [default: paper/depth-classical]
    #[arg(value_name = "SCENARIO")]
    scenario: Option<String>,
    /// Horizontal axis of the map
    #[arg(long, value_name = "KEY=LOW:HIGH:COUNT", default_value = DEFAULT_X)]
    x: String,
    /// Vertical axis of the map
    #[arg(long, value_name = "KEY=LOW:HIGH:COUNT", default_value = DEFAULT_Y)]
    y: String,
    /// Also simulate every point of the map, from equilibrium in the tissue, and list disagreements
    #[arg(long)]
    simulate: bool,
    /// Range of the tissue stiffness (N/m) for the analysis of events and of bounded hands; the stiffness can change
    /// within it at any tick [default: the range of the scenario's tissue]
    #[arg(long, value_name = "LOW:HIGH")]
    tissue: Option<String>,
    /// Range of the tissue damping (N·s/m) for absolute stability with bounded tissues [default: the damping of the
    /// scenario]
    #[arg(long, value_name = "LOW:HIGH")]
    tissue_damping: Option<String>,
    /// Range of the damping of hands (N·s/m) for absolute stability: any passive hand behind dampers of LOW and HIGH;
    /// HIGH can be inf
    #[arg(long, value_name = "LOW:HIGH", default_value = DEFAULT_HAND)]
    hand: String,
    /// Also compute Llewellyn's parameter and the damping that a hand needs over a parameter, and write absolute.csv
    /// and the figure absolute
    #[arg(long, value_name = "KEY=LOW:HIGH:COUNT")]
    absolute: Option<String>,
    /// Also compute the poles of the closed loop over a parameter, and write locus.csv and the figure locus
    #[arg(long, value_name = "KEY=LOW:HIGH:COUNT")]
    locus: Option<String>,
    /// Also compute the Z-width, the maximum stiffness of stable and of passive walls over their damping (N·s/m), and
    /// write z_width.csv
    #[arg(long, value_name = "LOW:HIGH:COUNT")]
    z_width: Option<String>,
    /// Also analyse the loop with the measured frequency response of the master, from the feedback force (N) to the
    /// handle's position in its direction (m), with the hand on it: a CSV with frequency_hz, magnitude (or magnitude_db)
    /// and phase_deg (or phase_rad). Writes measured_loop_gain.csv and the figure measured
    #[arg(long, value_name = "FILE")]
    master_response: Option<PathBuf>,
    /// The same with the measured frequency response of the slave, from its reference (m) to the position of the free
    /// needle (m)
    #[arg(long, value_name = "FILE")]
    slave_response: Option<PathBuf>,
    /// Also compute the limits for COUNT people drawn at random around the scenario's arm, and write population.csv.
    /// The flag is short for --set population.arm=people and population.size. The [population] of a scenario can also
    /// draw tissues and delays
    #[arg(long, value_name = "COUNT", value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    arms: Option<u64>,
    /// Also search for the limits of the certificate of events, such as the largest certified amplification; takes minutes
    #[arg(long)]
    event_limits: bool,
    /// Verify a certificate.json of SCENARIO instead, without an analysis: rebuild the inequalities from the scenario
    /// and check them in interval arithmetic, for the range of the tissue in the file. Give the --set of the analysis.
    /// Exit code 1 if the certificate does not hold
    #[arg(long, value_name = "FILE", conflicts_with_all = ANALYSIS)]
    verify: Option<PathBuf>,
    /// Also write report.html: one self-contained page with the map, limits, sensitivities, ports and events
    #[arg(long)]
    report: bool,
    #[command(flatten)]
    changes: ScenarioArgs,
    #[command(flatten)]
    output: OutputArgs,
}

impl StabilityArgs {
    fn changes(&self) -> ScenarioArgs {
        let of_arms = |count: u64| ["population.arm=people".to_owned(), format!("population.size={count}")];
        let settings = self.changes.settings.iter().cloned().chain(self.arms.into_iter().flat_map(of_arms));
        ScenarioArgs { settings: settings.collect() }
    }
}

fn verified(args: &StabilityArgs, path: &Path) -> Result<(), Failure> {
    let file = path.display();
    let scenario = args.scenario.clone().ok_or_else(|| {
        Failure::input(format!(
            "a certificate holds for one scenario; name it: trocar stability SCENARIO --verify {file}"
        ))
    })?;
    let scenario = args.changes.load(&[scenario])?.remove(0);
    let text = std::fs::read_to_string(path).map_err(|error| Failure::input(format!("{file}: {error}")))?;
    let all = verify(&text, &scenario).map_err(|error| {
        let message = format!("{file}: {error}");
        if matches!(error, VerificationError::Form(_)) { Failure::input(message) } else { Failure::work(message) }
    })?;
    let mut out = std::io::stdout().lock();
    for Verified { name, conditions, claim } in all {
        writeln!(out, "{name}: {conditions} conditions hold: {claim}").map_err(terminal::failed)?;
    }
    Ok(())
}

pub(super) fn run(args: &StabilityArgs) -> Result<(), Failure> {
    if let Some(path) = &args.verify {
        return verified(args, path);
    }
    let name = args.scenario.as_deref().unwrap_or(DEFAULT_SCENARIO);
    let axis = |text: &String| Axis::parse(text).map_err(|reason| Failure::input(format!("{text}: {reason}")));
    let (x, y) = (axis(&args.x)?, axis(&args.y)?);
    if x.parameter.varies_with(y.parameter) {
        return Err(Failure::input(format!(
            "{}: sets the same parameter as --x {}; choose two different parameters",
            args.y, args.x
        )));
    }
    let of_locus = args.locus.as_ref().map(axis).transpose()?;
    let of_absolute = args.absolute.as_ref().map(axis).transpose()?;
    let of_hand = dampings(&args.hand, f64::INFINITY)?;
    let of_tissue = args.tissue_damping.as_ref().map(|range| dampings(range, MAX_DAMPING_N_S_PER_M)).transpose()?;
    let of_walls = args.z_width.as_ref().map(|range| walls(range)).transpose()?;
    let scenario = args.changes().load(&[name.to_owned()])?.remove(0);
    let sector = args.tissue.as_ref().map(|range| tissue(range)).transpose()?;
    let folder = args.output.destination().open("stability", &scenario.name)?;
    let bar = progress::elapsed("analyses the loop and searches for a certificate of its events", args.output.quiet);
    let mut study = StabilityStudy::of(&scenario, (x, y), sector)?;
    bar.finish_and_clear();
    if let Some(axis) = &of_walls {
        study.compute_z_width(axis)?;
    }
    let (master, slave) = (response(args.master_response.as_deref())?, response(args.slave_response.as_deref())?);
    if master.is_some() || slave.is_some() {
        study.compute_measured(&MeasuredSides { master, slave })?;
    }
    if of_absolute.is_some() || of_tissue.is_some() || args.hand != DEFAULT_HAND {
        let damping_n_s_per_m = of_tissue.unwrap_or(study.bounded.terminations.damping_n_s_per_m);
        let terminations = Terminations { hand_n_s_per_m: of_hand, damping_n_s_per_m, ..study.bounded.terminations };
        study.compute_absolute(&terminations, of_absolute.as_ref())?;
    }
    if args.simulate {
        let bar = progress::rated_bar(study.map.stable.len(), args.output.quiet);
        bar.set_message("runs");
        study.simulate(&scenario, interrupt::stop_flag(), || bar.inc(1))?;
        bar.finish_and_clear();
    }
    if args.event_limits {
        let bar = progress::elapsed("searches for the limits of an event's parameters", args.output.quiet);
        study.compute_event_limits()?;
        bar.finish_and_clear();
    }
    if let Some(axis) = &of_locus {
        study.compute_locus(axis)?;
    }
    study.make_worst_events(&Source::parse(name), &args.changes.settings)?;
    let warnings = Warnings::new(&args.output);
    let document = study.document();
    warnings.print(&keys_outside_loop(&scenario, &args.changes.settings));
    warnings.print(&document.warnings);
    let again = || Again {
        command: "trocar stability",
        files: vec![(format!("{}.toml", scenario.name), scenario.echo())],
        line: command(args, &scenario.name),
        note: Again::SAVE,
    };
    Finish { output: &args.output, folder: folder.clone(), all: false, report: args.report.then(again) }
        .document(&document)?;
    let StabilityStudy { map, check, .. } = &study;
    if let Some(check) = check {
        let kept = check.simulated.iter().flatten().count();
        if kept < map.stable.len() {
            let kept = format!("{kept} of {} runs are in {}", map.stable.len(), folder.path.display());
            return Err(Failure::interrupted(&kept));
        }
    }
    warnings.finish()
}

fn command(args: &StabilityArgs, name: &str) -> String {
    let mut words = vec!["stability".to_owned(), format!("{name}.toml")];
    for (flag, value, default) in
        [("--x", &args.x, DEFAULT_X), ("--y", &args.y, DEFAULT_Y), ("--hand", &args.hand, DEFAULT_HAND)]
    {
        if value != default {
            words.extend([flag.to_owned(), value.clone()]);
        }
    }
    let file = |path: &Option<PathBuf>| path.as_ref().map(|path| path.display().to_string());
    let further = [
        ("--tissue", &args.tissue),
        ("--tissue-damping", &args.tissue_damping),
        ("--absolute", &args.absolute),
        ("--locus", &args.locus),
        ("--z-width", &args.z_width),
        ("--master-response", &file(&args.master_response)),
        ("--slave-response", &file(&args.slave_response)),
    ];
    for (flag, value) in further {
        words.extend(value.iter().flat_map(|value| [flag.to_owned(), value.clone()]));
    }
    let flags = [("--simulate", args.simulate), ("--event-limits", args.event_limits)];
    words.extend(flags.iter().filter(|(_, is_set)| *is_set).map(|(flag, _)| (*flag).to_owned()));
    command_line(words.into_iter().chain(["--report".to_owned()]))
}

fn response(file: Option<&Path>) -> Result<Option<FrequencyResponse>, Failure> {
    let Some(file) = file else { return Ok(None) };
    let rows = open_response(file, &Limits::default())?;
    let rows = rows.iter().map(|row| [row.frequency_hz, row.magnitude, row.phase_rad]);
    Ok(FrequencyResponse::new(rows))
}

fn walls(text: &str) -> Result<Axis, Failure> {
    let axis = format!("{}={text}", Parameter::Damping.key());
    Axis::parse(&axis).map_err(|reason| Failure::input(format!("{text}: {reason}")))
}

fn dampings(text: &str, max: f64) -> Result<(f64, f64), Failure> {
    let numbers =
        text.split_once(':').and_then(|(low, high)| Some((low.trim().parse().ok()?, high.trim().parse().ok()?)));
    let is_range =
        |(low, high): &(f64, f64)| 0.0 <= *low && *low <= MAX_DAMPING_N_S_PER_M && low <= high && *high <= max;
    numbers.filter(is_range).ok_or_else(|| {
        Failure::input(format!("{text}: write LOW:HIGH in N·s/m, as in 10:200, from 0 to {MAX_DAMPING_N_S_PER_M}"))
    })
}

fn tissue(text: &str) -> Result<(f64, f64), Failure> {
    let numbers =
        text.split_once(':').and_then(|(low, high)| Some((low.trim().parse().ok()?, high.trim().parse().ok()?)));
    numbers.filter(|range| is_tissue(*range)).ok_or_else(|| {
        Failure::input(format!("{text}: write LOW:HIGH in N/m, as in 50:600, from 0 to {MAX_STIFFNESS_N_PER_M}"))
    })
}
