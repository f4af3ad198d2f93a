//! The command line.

mod calibrate;
mod check;
mod compare;
mod detect;
mod error;
mod explore;
mod init;
mod interrupt;
mod manual;
mod progress;
mod record;
mod recorded;
mod report;
mod roc;
mod run;
mod scenarios;
mod stability;
mod sweep;
mod terminal;

use std::process::ExitCode;

use clap::{Args, Parser, Subcommand};

use error::CliError;
use trocar_sim::scenario::{Scenario, Source, json_schema};
use trocar_sim::sweep::sweep_schema;

/// Simulates needle insertions by bilateral teleoperation, with event-based haptic augmentation.
///
/// A person pushes a master, a slave pushes a needle, tissue pushes back. When a layer ruptures the needle lurches: trocar
/// detects the rupture, freezes the slave, exaggerates the felt force drop, and says in numbers what that buys.
#[derive(Debug, Parser)]
#[command(name = "trocar", version, after_help = EXAMPLES, arg_required_else_help = true)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

const EXAMPLES: &str = "\
Examples:
  trocar compare                                      classical against augmented, on the shipped insertion
  trocar init my.toml && trocar run my.toml           a scenario of your own
  trocar run builtin:augmented.toml --set augmentation.reengage=snap
  trocar explore                                      the same in the browser, with sliders
  trocar detect force.csv --time t_s --position x_mm:1e-3 --force f_n --contact-m 0.012

Exit codes: 0 done, 1 the work failed, 2 the input is wrong, 130 interrupted by Ctrl-C.";

#[derive(Debug, Subcommand)]
enum Command {
    /// Run scenarios: metrics, trace, figures
    ///
    /// Each scenario leaves trace.csv, summary.json, scenario.toml (every default written out; running it again gives the
    /// same bytes) and figures in a folder of its name.
    Run(run::RunArgs),
    /// Compare scenarios; with none, the shipped pair: classical against augmented
    ///
    /// Prints the metrics side by side, and for the shipped pair the paper's facts beside ours. Each scenario is also run
    /// with 0.025 N of added noise, by its own detector and by the derivative that the paper compares with.
    Compare(compare::CompareArgs),
    /// Open a page to explore: both schemes, simulated anew at every move of a slider
    ///
    /// Classical beside augmented in the browser: positions, forces, decision function and modes; sliders and switches for
    /// every key; the metrics that `compare` prints; the stability map, to click into; the rupture to be heard; and the needle
    /// to be pushed by hand, in real time. The state is in the page's address and goes into TOML, CSV and PNG.
    ///
    ///   trocar explore                                   the shipped insertion
    ///   trocar explore builtin:01_augmented.toml         through the skin
    ///   trocar explore my.toml --port 8000 --no-open     a scenario of your own, the browser left alone
    ///
    /// The program serves the page itself, on this machine alone: other machines are let in by --bind only, and pages of other
    /// sites never. Ctrl-C ends it.
    #[command(verbatim_doc_comment)]
    Explore(explore::ExploreArgs),
    /// Run the estimator and the detector on recordings of your own, or on a live stream
    ///
    /// A column is given by its name in the file's header, with a factor that turns it into SI after a colon: a lever's
    /// angle becomes metres with xs_rad:0.075. A negative factor turns the sign: forces must be positive when they resist
    /// insertion, positions must grow into the tissue. Uneven samples are resampled at their median interval.
    Detect(Box<detect::DetectArgs>),
    /// Find settings of estimator and detector from the beginning of a recording
    ///
    /// Measures the force's noise, finds where contact begins and what is quiet, tests whether the residual is white and
    /// Gaussian, and gives the dead zone, the estimator's memory, and drift and threshold for a wanted interval between false
    /// alarms, as [estimator] and [detector] tables to paste into a scenario.
    Calibrate(Box<calibrate::CalibrateArgs>),
    /// Judge the detectors: detection, delay and false alarms against the threshold
    ///
    /// White noise of many seeds is added to a signal's force. The estimator runs over it once, and every detector at many
    /// thresholds on what it leaves: the paper's squared residual, eq. 22, 23 and 26, the derivative baseline, a generalised
    /// likelihood ratio and the Page-Hinkley test, each with the threshold and the drift that follow from the same hypotheses.
    /// An alarm in time after a label is a detection; later within 0.5 s it is late; any other one is false. Intervals hold
    /// 95 %. Ctrl-C ends early and keeps the cases that are done.
    ///
    ///   trocar roc                                            the shipped insertion in the paper's noise
    ///   trocar roc --noise-std-n 0.01,0.025,0.05              less and more of it
    ///   trocar roc --drop-n 0.5,1,2 --sharpness-s 0.01,0.045  smaller and sharper ruptures
    ///   trocar roc builtin:real_classical.toml                a real recording with its label
    ///   trocar roc builtin:01_through_the_skin.toml           the loop closed over layers
    #[command(verbatim_doc_comment)]
    Roc(Box<roc::RocArgs>),
    /// Say where the loop is stable: limits, margins, ports, and a map over two parameters
    ///
    /// In permanent contact with a tissue f = K x + B v the loop is linear and repeats every tick. What is printed and drawn
    /// follows from its matrices, delays of any length included, and not from runs: the dominant mode; the greatest stable
    /// force scale, position scale, stiffness and delay, with the ranges where they are not one; gain, phase and delay margins;
    /// by how much each limit moves with each parameter; and the teleoperator as a two-port between any hand and any tissue
    /// (hybrid parameters, Llewellyn's parameter, passivity, transmitted impedance). K and B are tissue.stiffness_n_per_m and
    /// tissue.damping_n_s_per_m, whatever the scenario's tissue is.
    ///
    ///   trocar stability builtin:classical.toml                        force scale by stiffness
    ///   trocar stability my.toml --set tissue.stiffness_n_per_m=400    at another tissue
    ///   trocar stability my.toml --x channel.delay_s=0:0.1:100 --y scaling.force=0.1:10:100
    ///   trocar stability my.toml --x tissue.damping_n_s_per_m=0:50:100 --y tissue.stiffness_n_per_m=10:10000:100
    ///   trocar stability my.toml --simulate                            and hold every verdict against the engine
    ///
    /// An axis is KEY=LOW:HIGH:COUNT, spaced by ratios where HIGH is 50 times LOW or more (:log or :linear at the end say
    /// otherwise); channel.delay_s is both delays at once. With tissue damping across and stiffness upwards the map is the
    /// Z-width of Colgate and Brown (1994).
    ///
    /// Files, in a folder of the scenario's name: stability.json, sensitivities.csv, stability_map.csv and
    /// stability_boundary.csv behind stability.png, ports.csv behind ports.png.
    #[command(verbatim_doc_comment)]
    Stability(Box<stability::StabilityArgs>),
    /// Run a scenario many times over, with keys that vary: a row of metrics per case, statistics, figures
    ///
    /// On all processors, in constant memory, in parts on many machines; whatever ends it, the same command continues.
    Sweep(Box<sweep::SweepArgs>),
    /// Write the in-vivo-like recording, or one of another seed
    ///
    /// A made insertion through two layers with the facts that the paper states of its own: CSV with time_s, position_m,
    /// velocity_m_per_s and force_n, 1 kHz, forces positive when they resist insertion. The same seed gives the same bytes;
    /// seed 1 is the recording that is shipped.
    Record(record::RecordArgs),
    /// Check scenarios without running them
    Check(check::CheckArgs),
    /// List the shipped scenarios, each with its question
    Scenarios,
    /// Print a JSON Schema of scenario files, for editors
    Schema {
        /// Of sweep files instead
        #[arg(long)]
        sweep: bool,
    },
    /// Write a commented starter scenario
    Init(init::InitArgs),
    /// Print completions for a shell
    ///
    ///   trocar completions bash > ~/.local/share/bash-completion/completions/trocar
    ///   trocar completions zsh > "${fpath[1]}/_trocar"
    ///   trocar completions fish > ~/.config/fish/completions/trocar.fish
    #[command(verbatim_doc_comment)]
    Completions(manual::CompletionsArgs),
    /// Print the manual page, or write those of every command
    ///
    ///   trocar man | man -l -
    ///   trocar man --out ~/.local/share/man/man1
    #[command(verbatim_doc_comment)]
    Man(manual::ManArgs),
}

/// Where to write, and what to say.
#[derive(Debug, Args)]
struct OutputArgs {
    /// Folder for the files; one folder per scenario is made in it
    #[arg(long, value_name = "DIR", default_value = "out")]
    out: std::path::PathBuf,
    /// Say nothing but errors
    #[arg(long, short)]
    quiet: bool,
    /// Print on standard output what the JSON files hold, instead of tables
    #[arg(long)]
    json: bool,
}

/// Which scenarios, and what to change in them.
#[derive(Debug, Args)]
struct ScenarioArgs {
    /// Override a key in every scenario, as in --set scaling.force=2 (repeatable, the last one counts)
    #[arg(long = "set", value_name = "SECTION.KEY=VALUE")]
    settings: Vec<String>,
}

impl ScenarioArgs {
    /// Loads scenarios; all of them, before anything is run or written.
    fn load(&self, paths: &[String]) -> Result<Vec<Scenario>, CliError> {
        let load = |path: &String| {
            Scenario::load(&Source::parse(path), &self.settings).map_err(|mut error| {
                if error.place.is_none() && !error.message.contains(path.as_str()) {
                    error.message = format!("{path}: {}", error.message);
                }
                error
            })
        };
        let scenarios = paths.iter().map(load).collect::<Result<Vec<_>, _>>()?;
        for (index, scenario) in scenarios.iter().enumerate() {
            if let Some(other) = scenarios[..index].iter().position(|other| other.name == scenario.name) {
                let (first, second) = (paths[other].clone(), paths[index].clone());
                return Err(CliError::SameName { name: scenario.name.clone(), first, second });
            }
        }
        Ok(scenarios)
    }
}

/// Reads the command line, does what it says, and gives the exit code.
#[must_use]
pub fn main() -> ExitCode {
    let done = match Cli::parse().command {
        Command::Run(args) => run::run(&args),
        Command::Compare(args) => compare::run(&args),
        Command::Explore(args) => explore::run(&args),
        Command::Detect(args) => detect::run(*args),
        Command::Calibrate(args) => calibrate::run(&args),
        Command::Roc(args) => roc::run(&args),
        Command::Stability(args) => stability::run(&args),
        Command::Record(args) => record::run(&args),
        Command::Check(args) => check::run(&args),
        Command::Scenarios => scenarios::run(),
        Command::Sweep(args) => sweep::run(&args),
        Command::Schema { sweep: false } => terminal::print(&format!("{:#}\n", json_schema())),
        Command::Schema { sweep: true } => terminal::print(&format!("{:#}\n", sweep_schema())),
        Command::Init(args) => init::run(&args),
        Command::Completions(args) => manual::completions(&args),
        Command::Man(args) => manual::man(&args),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => error.report(),
    }
}
