mod address;
mod end;
mod pace;
mod peer;
mod priority;
mod replay;
mod side;

use std::path::PathBuf;

use clap::{Args, Subcommand};

use super::error::Failure;
use super::format::FormatArgs;

const EXAMPLES: &str = "\
Examples:
  trocar link slave layers/skin-augmented &
  trocar link master layers/skin-augmented
  trocar link replay out/skin-augmented

  trocar link slave my.toml --listen 0.0.0.0:7711 --key-file key
  trocar link master my.toml --to robot.lan:7711 --key-file key";

const MASTER_EXAMPLES: &str = "\
Examples:
  trocar link master layers/skin-augmented
  trocar link master my.toml --to robot.lan:7711 --key-file key";

const SLAVE_EXAMPLES: &str = "\
Examples:
  trocar link slave layers/skin-augmented
  trocar link slave my.toml --listen 0.0.0.0:7711 --key-file key";

/// Run the two sides in two processes.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct LinkArgs {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// The operator's side: operator, master, force law
    Master(MasterArgs),
    /// The needle's side: slave, tissue, sensors, detector, supervisor
    Slave(SlaveArgs),
    /// Simulate a logged link with its logged delays, and compare bit for bit
    ///
    /// The folder must contain the folders master and slave. The command writes into its folder replay: delays.csv,
    /// with the delays of both directions, and replay.toml, a scenario with these delays; trocar run on replay.toml
    /// gives the same result. The comparison reports the first tick at which a signal of the link differs from this simulation. It
    /// also reports the first tick at which the link differs from a simulation with the scenario's own channel: from
    /// this tick on, the real delays changed the result.
    ///
    /// The exit code is 1 if the link differs from the simulation with its delays.
    Replay(replay::ReplayArgs),
}

#[derive(Debug, Args)]
#[command(after_help = MASTER_EXAMPLES)]
struct MasterArgs {
    #[command(flatten)]
    side: SideArgs,
    /// Address of the slave
    #[arg(long, value_name = "HOST:PORT", default_value = "127.0.0.1:7711")]
    to: String,
    /// Time to wait for the slave, in s
    #[arg(long, value_name = "S", default_value = "10", value_parser = clap::value_parser!(u32).range(1..=3600))]
    wait_s: u32,
}

#[derive(Debug, Args)]
#[command(after_help = SLAVE_EXAMPLES)]
struct SlaveArgs {
    #[command(flatten)]
    side: SideArgs,
    /// Address to listen at; port 0 is any free port, which is printed
    #[arg(long, value_name = "HOST:PORT", default_value = "127.0.0.1:7711")]
    listen: String,
}

#[derive(Debug, Args)]
#[command(mut_arg("format", |arg| arg.help("Formats of the trace besides csv, separated by commas")))]
struct SideArgs {
    /// A scenario file, or the name of a shipped scenario; the same on both sides
    #[arg(value_name = "SCENARIO")]
    scenario: String,
    /// Override a key, as in --set scaling.force=2 (repeatable; the last value applies)
    #[arg(long = "set", value_name = "SECTION.KEY=VALUE")]
    settings: Vec<String>,
    /// File with the key of both sides, at least 16 bytes; required if an address belongs to another machine
    #[arg(long, value_name = "FILE")]
    key_file: Option<PathBuf>,
    /// Ask the scheduler for real-time priority; the summary reports the priority granted
    #[arg(long)]
    realtime: bool,
    /// Folder for the files; it contains one folder per scenario, with a folder per side
    #[arg(long, value_name = "DIR", default_value = "out")]
    out: PathBuf,
    #[command(flatten)]
    format: FormatArgs,
    /// Print errors only
    #[arg(long, short)]
    quiet: bool,
    /// Print summary.json on standard output, instead of tables
    #[arg(long)]
    json: bool,
}

pub(super) fn run(args: &LinkArgs) -> Result<(), Failure> {
    match &args.command {
        Command::Master(args) => side::master(args),
        Command::Slave(args) => side::slave(args),
        Command::Replay(args) => replay::run(args),
    }
}
