mod calibrate;
mod check;
mod compare;
mod completions;
mod design;
mod detect;
mod error;
mod explain;
mod explore;
mod export;
mod figure;
mod finish;
mod format;
mod help;
mod identify;
mod init;
mod interrupt;
mod link;
mod manual;
mod paper;
mod progress;
mod quantity;
mod record;
mod recorded;
mod report;
mod roc;
mod run;
mod scenarios;
mod schema;
mod stability;
mod strategies;
mod sweep;
mod terminal;
mod warnings;
mod within;

use std::path::Path;
use std::process::ExitCode;

use clap::{Args, CommandFactory as _, FromArgMatches as _, Parser, Subcommand};

use error::Failure;
use trocar_report::Destination;
use trocar_scenario::{Scenario, ScenarioError, Source};

/// Simulates needle insertions by bilateral teleoperation, with event-based haptic augmentation.
///
/// An operator moves a master, a slave drives a needle, and the tissue force is fed back to the operator. When a
/// layer ruptures, the needle overshoots. trocar detects the rupture, freezes the slave, amplifies the drop of the
/// felt force, and computes metrics of the run.
#[derive(Debug, Parser)]
// Each paragraph of the help is one line, which clap wraps; lines of examples and lists are shorter.
#[command(name = "trocar", version, after_help = EXAMPLES, arg_required_else_help = true, max_term_width = trocar_report::WIDTH)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

const EXAMPLES: &str = "\
Examples:
  trocar compare                             classical and augmented
  trocar init my.toml && trocar run my.toml  your scenario
  trocar run layers/skin-augmented --set augmentation.reengage=snap
  trocar explore                             interactive, in the browser
  trocar detect force.csv --time t_s --position x_mm:1e-3 --force f_n
  trocar explain missed-rupture              a warning, a key or a metric

Exit codes: 0 success, 1 failure, 2 invalid input, 130 interrupted by Ctrl-C.";

#[derive(Debug, Subcommand)]
enum Command {
    /// Run scenarios: metrics, trace, figures
    ///
    /// For each scenario, a folder with its name receives trace.csv, summary.json, scenario.toml and figures.
    /// scenario.toml contains every default; running it gives identical files.
    Run(run::RunArgs),
    /// Compare scenarios; without arguments, the shipped classical and augmented scenarios
    ///
    /// Prints the conclusions of the comparison, and the main metrics side by side. Each scenario also runs with
    /// 0.025 N of added noise, once with its own detector and once with the derivative detector of the paper: --all
    /// prints these metrics too.
    Compare(compare::CompareArgs),
    /// Compare the strategies against a rupture, or the passivity schemes of the link, on one scenario
    ///
    /// Every strategy runs for every patient, person and seed. The table shows the excess advance, whether the person
    /// notices the rupture, and the cost of a false alarm; a star marks the strategies on the Pareto front. With
    /// --schemes, the scenario instead runs without a passivity scheme and with each scheme, and the table compares
    /// force, position, energy, felt impedance and overshoot.
    Strategies(strategies::StrategiesArgs),
    /// Explore a scenario in the browser, with a new simulation at every change of a slider
    ///
    /// The page shows classical and augmented teleoperation side by side: positions, forces, decision function and
    /// modes. It has sliders and switches for every key, the metrics of `compare`, an interactive stability map, the
    /// rupture as sound, and an insertion by hand in real time. The address of the page contains its state. The page
    /// exports TOML, CSV and PNG.
    ///
    /// The command serves the page on this machine only; use --bind to serve other machines. The server rejects
    /// requests from pages of other sites. Ctrl-C ends the server.
    Explore(explore::ExploreArgs),
    /// Run the estimator and the detector on recordings or on a live stream
    ///
    /// A recording is a file of delimited text (such as CSV), MATLAB, Parquet, TDMS, HDF5 or Excel; --list shows its
    /// signals. A column is given by its name in the header of the file and, after a colon, a factor or a unit (s,
    /// ms, us, ns, min; m, cm, mm, um; N, kN, cN, mN, gf, kgf): xs_rad:0.075 converts the angle of a lever to metres.
    /// A negative factor or unit, as in force:-cN, changes the sign: forces must be positive when they resist
    /// insertion, and positions must increase into the tissue. Unevenly spaced samples are resampled at their median
    /// interval.
    Detect(Box<detect::DetectArgs>),
    /// Compute settings of estimator and detector from the beginning of a recording
    ///
    /// Measures the noise of the force, finds the contact position and the quiet segments, and tests whether the
    /// residual is white and Gaussian. From these it computes the dead zone, the memory of the estimator, and the
    /// drift and threshold for a requested interval between false alarms. The result is a scenario's [estimator] and
    /// [detector] tables.
    Calibrate(Box<calibrate::CalibrateArgs>),
    /// Identify a machine from recordings: parameters with 95 % intervals, and predictions of other recordings
    ///
    /// The slave of a rig follows its master. From recordings of both positions, of the force on the slave and, if
    /// recorded, of the actuator's force, the command computes moving mass, friction and the gains of the controller.
    /// Recordings of --predict are not used for the estimation: their fit shows how well the machine generalises. The
    /// command lists what the recordings do not determine.
    Identify(Box<identify::IdentifyArgs>),
    /// Compute operating characteristics of the detectors: detection, delay and false alarms by threshold
    ///
    /// White noise of many seeds is added to the force of a signal. The estimator runs once per seed, and every
    /// detector runs on its residual with many thresholds. The detectors are the paper's squared residual, eq. 22, 23
    /// and 26, the derivative baseline, a generalised likelihood ratio and the Page-Hinkley test. Each has its own
    /// threshold and drift, derived from the same two noise levels (quiet and rupture). An alarm soon enough after a
    /// label is a detection; a later alarm within 0.5 s is late; any other alarm is false. Intervals are 95 %
    /// confidence intervals. Ctrl-C ends early and keeps the finished cases.
    Roc(Box<roc::RocArgs>),
    /// Analyse the stability of the loop: limits, margins, ports, and a map over two parameters
    ///
    /// In permanent contact with a tissue f = K x + B v the loop is linear and time-invariant. The analysis uses the
    /// matrices of the loop, with delays of any length, and no simulation. It computes the dominant mode; the maximum
    /// stable force scale, position scale, stiffness and delay, with all stable ranges; gain, phase, delay and jitter
    /// margins; the sensitivity of each limit to each parameter; and the two-port of the teleoperator (hybrid
    /// parameters, Llewellyn's parameter, passivity, transmitted impedance). K and B are tissue.stiffness_n_per_m and
    /// tissue.damping_n_s_per_m for every kind of tissue.
    ///
    /// An axis is KEY=LOW:HIGH:COUNT. It is logarithmic if HIGH is at least 50 times LOW; append :log or :linear to
    /// choose. channel.delay_s sets both delays. With tissue damping as x and stiffness as y, the map is the Z-width
    /// of Colgate and Brown (1994).
    ///
    /// The files are in a folder with the name of the scenario: stability.json, sensitivities.csv, the figure
    /// stability with stability_map.csv and stability_boundary.csv, and the figure ports with ports.csv. certificate.json
    /// proves the statement about events; --verify checks it apart from the search.
    Stability(Box<stability::StabilityArgs>),
    /// Run a scenario many times with varied keys: one row of metrics per case, statistics, figures
    ///
    /// A sweep uses all processors and constant memory, and its parts can run on many machines. After an
    /// interruption, the same command continues the sweep.
    Sweep(Box<sweep::SweepArgs>),
    /// Find the settings of a scenario that are best for a group of patients
    ///
    /// A file names the free keys with their ranges, the objectives and the constraints, over patients, persons and
    /// noise. The search finds a front: designs that no other one beats in every objective. Other patients then judge
    /// these designs and the shipped strategies. After an interruption, the same command continues the search.
    Design(Box<design::DesignArgs>),
    /// Write a scenario as a functional mock-up unit (FMU) for other simulation programs
    ///
    /// The FMU is the whole simulation, with the operator's position as input and the columns of the trace as
    /// outputs; with --rig, it is the controller of a rig, with samples as inputs and the commands and the alarm as
    /// outputs. Its parameters are the keys of the scenario, with their values as defaults. A step is a whole number
    /// of ticks; after a step from t to t + h, the outputs are those of the last tick before t + h.
    Export(export::ExportArgs),
    /// Run the two sides of a scenario as two processes in real time, or simulate a logged link again
    ///
    /// Master and slave exchange one UDP packet per tick, with a number and a time stamp. Both run the steps of a
    /// simulated tick, and the network replaces the channel: architectures, recovery, passivity schemes and
    /// augmentation act as in a run. Each side logs its signals and the delays and losses of the messages that it
    /// receives; replay simulates the link from these logs.
    ///
    /// On one machine no key is needed. Between machines every packet is authenticated with a key. Packets with
    /// another key, of another session or with an old number are counted and dropped. The packets are not encrypted.
    ///
    /// The slave's ticks are half a tick after the master's.
    Link(link::LinkArgs),
    /// Check scenarios, sweep files and design files without running them
    Check(check::CheckArgs),
    /// Explain a warning, a key or a metric; without an argument, list all warnings
    Explain(explain::ExplainArgs),
    /// List the shipped scenarios with the question that each answers, or print one
    Scenarios(scenarios::ScenariosArgs),
    /// Reproduce the figures of the paper, each with the paper's statements
    ///
    /// Runs the shipped scenarios and draws figure 1 and figures 4 to 16 by number. paper.html contains all of them,
    /// with a description of the paper's figure, the differences and their reasons, and the paper's statements beside
    /// the results.
    Paper(paper::PaperArgs),
    /// Write a commented starter scenario
    ///
    /// A starter is short and valid as written. To override a default, uncomment its line `# key = value`; the value
    /// is the default or marked as an example.
    /// Without a flag, the starter is --layers: a user-defined tissue, which needs no other file.
    Init(init::InitArgs),
    /// Print the JSON Schema of scenario files, or of a JSON file, with units and meanings
    Schema(schema::SchemaArgs),
    /// Write the in-vivo-like recording, or a variant with another seed
    ///
    /// The recording is a synthetic insertion through two layers with the properties that the paper states for its
    /// own recording. It is a CSV file at 1 kHz with time_s, position_m, velocity_m_per_s and force_n; forces are
    /// positive when they resist insertion. The same seed gives an identical file; seed 1 is the shipped recording.
    Record(record::RecordArgs),
    /// Print completions for a shell
    Completions(completions::CompletionsArgs),
    /// Print the manual page, or write the manual pages of all commands
    Man(manual::ManArgs),
}

const OUT_PER_RECORDING: &str = "Folder for the files; it contains one folder per recording";

const OUT_PER_COMMAND: &str = "Folder for the files; it contains one folder with the name of the command";

const OUT_PER_SWEEP: &str = "Folder for the files; it contains one folder per sweep";

const SET_ONE: &str = "Override a key, as in --set scaling.force=2 (repeatable; the last value applies)";

/// Options for files and printed output.
#[derive(Debug, Args)]
struct OutputArgs {
    /// Folder for the files; it contains one folder per scenario
    #[arg(long, value_name = "DIR", default_value = "out")]
    out: std::path::PathBuf,
    /// Print errors only
    #[arg(long, short)]
    quiet: bool,
    /// Exit with code 1 if there is a warning; the files are still written
    #[arg(long)]
    deny_warnings: bool,
    /// Print the content of the JSON files on standard output, instead of tables
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    figures: figure::FigureArgs,
    /// Draw no figures; for short runs or many recordings, drawing takes most of the time
    #[arg(long)]
    no_figures: bool,
}

impl OutputArgs {
    fn destination(&self) -> Destination {
        let mut figures = self.figures.style();
        if self.no_figures {
            figures.formats.clear();
        }
        Destination { figures, ..Destination::new(&self.out) }
    }
}

/// Overrides of scenario keys.
#[derive(Debug, Args)]
struct ScenarioArgs {
    /// Override a key in every scenario, as in --set scaling.force=2 (repeatable; the last value applies)
    #[arg(long = "set", value_name = "SECTION.KEY=VALUE")]
    settings: Vec<String>,
}

impl ScenarioArgs {
    fn load(&self, paths: &[String]) -> Result<Vec<Scenario>, Failure> {
        let sources: Vec<Source> = paths.iter().map(|path| Source::parse(path)).collect();
        let named = |(loaded, path): (Result<Scenario, ScenarioError>, &String)| {
            loaded.map_err(|mut error| {
                if error.place.is_none() && !error.message.contains(path.as_str()) {
                    error.message = format!("{path}: {}", error.message);
                }
                error
            })
        };
        let loaded = Scenario::load_all(&sources, &self.settings);
        let scenarios = loaded.into_iter().zip(paths).map(named).collect::<Result<Vec<_>, _>>()?;
        for (index, scenario) in scenarios.iter().enumerate() {
            if let Some(other) = scenarios[..index].iter().position(|other| other.name == scenario.name) {
                let (first, second) = (&paths[other], &paths[index]);
                let remedy = if first == second {
                    format!("{first} is given twice; remove one")
                } else {
                    format!(
                        "{first} and {second}; change the name in one of them, or run them separately, each with its own \
                         --out"
                    )
                };
                return Err(Failure::input(format!(
                    "two scenarios have the name {:?} and would write into the same folder: {remedy}",
                    scenario.name
                )));
            }
        }
        Ok(scenarios)
    }
}

fn refuse_existing(path: &Path, is_forced: bool) -> Result<(), Failure> {
    if is_forced || !path.exists() {
        return Ok(());
    }
    Err(Failure::input(format!("{} already exists; give another path, or --force to replace it", path.display())))
}

/// Returns the exit code of the command.
pub fn main() -> ExitCode {
    let matches = help::grouped(Cli::command()).get_matches();
    let cli = Cli::from_arg_matches(&matches).unwrap_or_else(|error| error.exit());
    interrupt::begin();
    let result = execute(cli.command);
    interrupt::wait_for_end();
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => error.report(),
    }
}

fn execute(command: Command) -> Result<(), Failure> {
    match command {
        Command::Run(args) => run::run(&args),
        Command::Compare(args) => compare::run(&args),
        Command::Explore(args) => explore::run(&args),
        Command::Detect(args) => detect::run(*args),
        Command::Calibrate(args) => calibrate::run(&args),
        Command::Identify(args) => identify::run(&args),
        Command::Roc(args) => roc::run(&args),
        Command::Stability(args) => stability::run(&args),
        Command::Strategies(args) => strategies::run(&args),
        Command::Record(args) => record::run(&args),
        Command::Export(args) => export::run(&args),
        Command::Link(args) => link::run(&args),
        Command::Check(args) => check::run(&args),
        Command::Explain(args) => explain::run(&args),
        Command::Scenarios(args) => scenarios::run(&args),
        Command::Sweep(args) => sweep::run(&args),
        Command::Design(args) => design::run(&args),
        Command::Schema(args) => schema::run(&args),
        Command::Init(args) => init::run(&args),
        Command::Paper(args) => paper::run(&args),
        Command::Completions(args) => completions::run(&args),
        Command::Man(args) => manual::run(&args),
    }
}

#[cfg(test)]
mod tests;
