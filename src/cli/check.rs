use std::io::Write as _;

use clap::Args;
use schemars::JsonSchema;
use serde::Serialize;

use super::error::Failure;
use super::warnings::text;
use super::{ScenarioArgs, terminal};
use trocar_base::warning::Warning;
use trocar_document::{json_of, to_json};
use trocar_report::wrapped;
use trocar_scenario::{Scenario, Source};
use trocar_studies::design::{Problem, is_design};
use trocar_studies::run::{foreseen, outside_measured, promise_gaps};
use trocar_studies::stability_check::{LoopPart, LoopVerdict};
use trocar_studies::sweep::{Plan, is_sweep};

const EXAMPLES: &str = "\
Examples:
  trocar check my.toml
  trocar check sweep.toml designs/liver.toml
  trocar check my.toml --resolved";

/// Check scenarios, sweep files and design files.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct CheckArgs {
    /// Scenario files, shipped scenarios, sweep files or design files
    #[arg(required = true, value_name = "SCENARIO|SWEEP|DESIGN")]
    files: Vec<String>,
    #[command(flatten)]
    changes: ScenarioArgs,
    /// Print the resolved scenario or sweep, including all defaults
    #[arg(long)]
    resolved: bool,
    /// Print errors only
    #[arg(long, short)]
    quiet: bool,
    /// Print the files as a JSON list, each with its name, its number of ticks or cases, and the verdict on its
    /// linear loop
    #[arg(long, conflicts_with = "resolved")]
    json: bool,
}

/// The verdict on the linear loop of a scenario, or the reason for having none. Runs nothing.
fn verdict(scenario: &Scenario) -> Result<LoopVerdict, String> {
    LoopVerdict::of(scenario).map_err(|error| error.to_string())
}

/// A valid file.
#[derive(Serialize, JsonSchema)]
#[serde(untagged)]
pub(super) enum CheckedFile<'a> {
    /// A scenario.
    Scenario {
        /// Name of the scenario.
        name: &'a str,
        #[schemars(extend("const" = "scenario"))]
        kind: &'static str,
        /// Number of ticks.
        ticks: u64,
        /// Length of a tick, in s.
        tick_s: f64,
        #[serde(rename = "loop")]
        of_loop: CheckedLoop<'a>,
        /// The warnings about the scenario.
        #[serde(skip_serializing_if = "Vec::is_empty")]
        warnings: Vec<Warning>,
    },
    /// A sweep file.
    Sweep {
        /// Name of the sweep.
        name: &'a str,
        #[schemars(extend("const" = "sweep"))]
        kind: &'static str,
        /// Number of cases.
        cases: u64,
    },
    /// A design file.
    Design {
        /// Name of the design.
        name: &'a str,
        #[schemars(extend("const" = "design"))]
        kind: &'static str,
        /// Number of free keys.
        free_keys: u64,
        /// Number of candidates of the search.
        candidates: u64,
    },
}

/// The linear loop of a scenario.
#[derive(Serialize, JsonSchema)]
#[serde(untagged)]
pub(super) enum CheckedLoop<'a> {
    /// The verdict.
    Known(Box<LoopPart>),
    /// The loop is not analysed.
    Unknown {
        /// The reason.
        reason: &'a str,
    },
}

impl<'a> CheckedLoop<'a> {
    fn known(verdict: &LoopVerdict) -> Self {
        Self::Known(Box::new(LoopPart::of(verdict)))
    }
}

pub(super) fn run(args: &CheckArgs) -> Result<(), Failure> {
    let (sweeps, scenarios): (Vec<String>, Vec<String>) =
        args.files.iter().cloned().partition(|file| is_sweep(&Source::parse(file)));
    let (designs, scenarios): (Vec<String>, Vec<String>) =
        scenarios.into_iter().partition(|file| is_design(&Source::parse(file)));
    let mut list = vec![];
    for scenario in args.changes.load(&scenarios)? {
        let verdict = verdict(&scenario);
        let mut found = promise_gaps(&scenario);
        found.extend(foreseen(&scenario));
        found.extend(outside_measured(&scenario));
        if !args.quiet && !args.json {
            for warning in &found {
                // Ignores a closed standard error.
                let _ = write!(anstream::stderr(), "{}", text(warning));
            }
        }
        if args.json {
            let (ticks, tick_s) = (scenario.grid.ticks(), scenario.grid.tick_s());
            let name = &scenario.name;
            let of_loop = verdict.as_ref().map_or_else(|reason| CheckedLoop::Unknown { reason }, CheckedLoop::known);
            list.push(json_of(&CheckedFile::Scenario {
                name,
                kind: "scenario",
                ticks,
                tick_s,
                of_loop,
                warnings: found,
            }));
        } else if args.resolved {
            terminal::print(&scenario.echo())?;
        } else if !args.quiet {
            let (ticks, tick_s) = (scenario.grid.ticks(), scenario.grid.tick_s());
            let loop_line =
                verdict.map_or_else(|reason| format!("not analysed ({reason})"), |verdict| verdict.sentence());
            let text = format!("{}: valid, {ticks} ticks of {tick_s} s\nlinear loop: {loop_line}\n", scenario.name);
            terminal::print(&wrapped(&text, 2))?;
        }
    }
    for file in &sweeps {
        let plan = Plan::load(&Source::parse(file), &args.changes.settings)?;
        if args.json {
            list.push(json_of(&CheckedFile::Sweep {
                name: &plan.design.name,
                kind: "sweep",
                cases: plan.design.cases(),
            }));
        } else if args.resolved {
            terminal::print(plan.canonical())?;
        } else if !args.quiet {
            let (name, cases) = (&plan.design.name, plan.design.cases());
            terminal::print(&format!("{name}: valid sweep, {cases} cases\n"))?;
        }
    }
    for file in &designs {
        let problem = Problem::load(&Source::parse(file), &args.changes.settings)?;
        let (name, free_keys) = (&problem.name, problem.free.len() as u64);
        let candidates = problem.search.candidates as u64 * problem.search.generations;
        if args.json {
            list.push(json_of(&CheckedFile::Design { name, kind: "design", free_keys, candidates }));
        } else if args.resolved {
            terminal::print(problem.canonical())?;
        } else if !args.quiet {
            terminal::print(&format!("{name}: valid design, {free_keys} free keys, {candidates} candidates\n"))?;
        }
    }
    if args.json { terminal::print(&to_json(&list.into())) } else { Ok(()) }
}
