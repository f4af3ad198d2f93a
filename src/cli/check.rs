//! `trocar check`.

use clap::Args;

use super::error::CliError;
use super::{ScenarioArgs, terminal};

const EXAMPLES: &str = "\
Examples:
  trocar check my.toml
  trocar check my.toml --resolved";

/// Check scenarios.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct CheckArgs {
    /// Scenario files
    #[arg(required = true, value_name = "FILE")]
    scenarios: Vec<String>,
    #[command(flatten)]
    changes: ScenarioArgs,
    /// Print the resolved scenario, including all defaults
    #[arg(long)]
    resolved: bool,
    /// Print errors only
    #[arg(long, short)]
    quiet: bool,
}

pub(super) fn run(args: &CheckArgs) -> Result<(), CliError> {
    for scenario in args.changes.load(&args.scenarios)? {
        if args.resolved {
            terminal::print(&scenario.echo())?;
        } else if !args.quiet {
            let (ticks, tick_s) = (scenario.grid.ticks(), scenario.grid.tick_s());
            terminal::print(&format!("{}: valid, {ticks} ticks of {tick_s} s\n", scenario.name))?;
        }
    }
    Ok(())
}
