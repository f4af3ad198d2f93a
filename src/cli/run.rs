use clap::Args;
use rayon::prelude::*;

use super::error::Failure;
use super::finish::Finish;
use super::format::FormatArgs;
use super::warnings::Warnings;
use super::{OutputArgs, ScenarioArgs, progress, report, terminal};
use trocar_document::{Study as _, to_json};
use trocar_report::{Destination, Folder, write_document};
use trocar_studies::run::{Run, RunReport, run as run_scenario};

const EXAMPLES: &str = "\
Examples:
  trocar run my.toml
  trocar run layers/skin-augmented --set scaling.force=2 --report";

/// Run scenarios.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct RunArgs {
    /// Scenario files, or shipped scenarios such as paper/classical (see `trocar scenarios`)
    #[arg(required = true, value_name = "SCENARIO")]
    scenarios: Vec<String>,
    /// Also write report.html into the folder of each trace.csv: one self-contained page with the scenario, the
    /// metrics and their meaning, the events, and interactive charts
    #[arg(long)]
    report: bool,
    #[command(flatten)]
    format: FormatArgs,
    #[command(flatten)]
    changes: ScenarioArgs,
    #[command(flatten)]
    output: OutputArgs,
}

pub(super) fn run(args: &RunArgs) -> Result<(), Failure> {
    let scenarios = args.changes.load(&args.scenarios)?;
    let destination = Destination { samples: args.format.formats().to_vec(), ..args.output.destination() };
    let bar = progress::bar(scenarios.len(), args.output.quiet);
    bar.set_message("running");
    let warnings = Warnings::new(&args.output);
    let mut summaries = vec![];
    for scenario in scenarios {
        let folder = destination.open("run", &scenario.name)?;
        let run = run_scenario(scenario)?;
        let report = RunReport::of(&run);
        let document = report.document();
        let report = args.report.then(|| report::again("trocar run", std::slice::from_ref(&run), []));
        let finish = Finish { output: &args.output, folder, all: false, report };
        finish.write(&document)?;
        finish.folder.commit()?;
        bar.inc(1);
        bar.suspend(|| warnings.print(&document.warnings));
        if args.output.json {
            summaries.push(document.json);
        } else {
            finish.print(&document)?;
        }
    }
    bar.finish_and_clear();
    if args.output.json {
        // Print the summary of one run as an object, and of several as a list.
        let document = match summaries.len() {
            1 => summaries.remove(0),
            _ => summaries.into(),
        };
        terminal::print(&to_json(&document))?;
    }
    warnings.finish()
}

pub(super) fn write_runs(folder: &Folder, runs: &[Run]) -> Result<(), Failure> {
    let write = |run: &Run| write_document(&folder.folder(&run.scenario.name), &RunReport::of(run).document());
    Ok(runs.par_iter().try_for_each(write)?)
}
