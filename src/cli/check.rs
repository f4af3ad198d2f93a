//! `trocar check`.

use std::io::Write as _;

use clap::Args;
use serde_json::json;

use super::error::CliError;
use super::warnings::text;
use super::{ScenarioArgs, source_of, terminal};
use trocar_sim::run::{force_bound_gap, outside_measured, promise_gaps};
use trocar_sim::scenario::Source;
use trocar_sim::sweep::{Plan, is_sweep};

const EXAMPLES: &str = "\
Examples:
  trocar check my.toml
  trocar check sweep.toml
  trocar check my.toml --resolved";

/// Check scenarios and sweep files.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct CheckArgs {
    /// Scenario or sweep files
    #[arg(required = true, value_name = "FILE")]
    files: Vec<String>,
    #[command(flatten)]
    changes: ScenarioArgs,
    /// Print the resolved scenario or sweep, including all defaults
    #[arg(long)]
    resolved: bool,
    /// Print errors only
    #[arg(long, short)]
    quiet: bool,
    /// Print a list of the files as JSON, each with its name, and its ticks or cases
    #[arg(long, conflicts_with = "resolved")]
    json: bool,
}

pub(super) fn run(args: &CheckArgs) -> Result<(), CliError> {
    let (sweeps, scenarios): (Vec<String>, Vec<String>) =
        args.files.iter().cloned().partition(|file| is_sweep(&Source::parse(file)));
    let mut list: Vec<serde_json::Value> = vec![];
    for scenario in args.changes.load(&scenarios)? {
        let mut found = promise_gaps(&scenario);
        found.extend(force_bound_gap(&scenario));
        found.extend(outside_measured(&scenario));
        if !args.quiet && !args.json {
            for warning in &found {
                // Standard error can be closed; the work continues.
                let _ = write!(anstream::stderr(), "{}", text(warning));
            }
        }
        if args.json {
            let (ticks, tick_s) = (scenario.grid.ticks(), scenario.grid.tick_s());
            let mut one = json!({ "name": scenario.name, "kind": "scenario", "ticks": ticks, "tick_s": tick_s });
            if !found.is_empty() {
                one["warnings"] = json!(found);
            }
            list.push(one);
        } else if args.resolved {
            terminal::print(&scenario.echo())?;
        } else if !args.quiet {
            let (ticks, tick_s) = (scenario.grid.ticks(), scenario.grid.tick_s());
            terminal::print(&format!("{}: valid, {ticks} ticks of {tick_s} s\n", scenario.name))?;
        }
    }
    for file in &sweeps {
        let plan = Plan::load(&source_of(file), &args.changes.settings)?;
        if args.json {
            list.push(json!({ "name": plan.design.name, "kind": "sweep", "cases": plan.design.cases() }));
        } else if args.resolved {
            terminal::print(plan.canonical())?;
        } else if !args.quiet {
            let (name, cases) = (&plan.design.name, plan.design.cases());
            terminal::print(&format!("{name}: valid sweep, {cases} cases\n"))?;
        }
    }
    if args.json { terminal::print(&format!("{:#}\n", serde_json::Value::from(list))) } else { Ok(()) }
}
