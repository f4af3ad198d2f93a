//! `trocar run`.

use clap::Args;
use rayon::prelude::*;

use super::error::CliError;
use super::format::FormatArgs;
use super::warnings::Warnings;
use super::{OutputArgs, ScenarioArgs, progress, report, terminal};
use trocar_document::{Document, Study as _};
use trocar_report::html::{Again, command_line, document_html};
use trocar_report::{Animation, Folder, document_text, runs_chart, to_json, write_document, write_trace};
use trocar_studies::run::{Run, run as run_scenario};

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
    /// Also write report.html in the folder of each trace.csv: one self-contained page with the scenario, the metrics and their
    /// meaning, the events, and interactive charts
    #[arg(long)]
    report: bool,
    #[command(flatten)]
    format: FormatArgs,
    #[command(flatten)]
    changes: ScenarioArgs,
    #[command(flatten)]
    output: OutputArgs,
}

pub(super) fn run(args: &RunArgs) -> Result<(), CliError> {
    let scenarios = args.changes.load(&args.scenarios)?;
    let folder = args.output.folder();
    let bar = progress::bar(scenarios.len(), args.output.quiet);
    bar.set_message("running");
    let warnings = Warnings::new(&args.output);
    let mut summaries = vec![];
    for scenario in scenarios {
        let run = run_scenario(scenario)?;
        let document = run.document();
        write_run(&folder, &run, &document, &args.format)?;
        let written = folder.folder(&run.scenario.name);
        if args.report {
            let file = format!("{}.toml", run.scenario.name);
            let again = Again {
                command: "trocar run",
                line: command_line(["run", &file, "--report"]),
                files: vec![(file, run.scenario.echo())],
                animation: Animation::of(&[&run]),
                note: Again::SAVE,
            };
            written.write(report::FILE, document_html(&document, &again)?.as_bytes())?;
        }
        bar.inc(1);
        bar.suspend(|| warnings.print(&document.warnings));
        if args.output.json {
            summaries.push(document.json);
        } else if !args.output.quiet {
            terminal::draw(|| runs_chart(std::slice::from_ref(&run)))?;
            terminal::print(&format!("{}files: {}\n", document_text(&document, false), written.path().display()))?;
            if args.report {
                report::print_path(&written)?;
            }
        }
    }
    bar.finish_and_clear();
    if args.output.json {
        // One document: the summary of one run, or a list of several.
        let document = match summaries.len() {
            1 => summaries.remove(0),
            _ => summaries.into(),
        };
        terminal::print(&to_json(&document))?;
    }
    warnings.finish()
}

/// Writes the files of a run into a folder with its name: trace, summary, resolved scenario, figures.
fn write_run(folder: &Folder, run: &Run, document: &Document<'_>, format: &FormatArgs) -> Result<(), CliError> {
    let folder = folder.folder(&run.scenario.name);
    let trace = || format.write(&folder, "trace", |format, out| write_trace(&run.trace, format, out));
    let (trace, document) = rayon::join(trace, || write_document(&folder, document));
    trace?;
    Ok(document?)
}

/// Writes several runs in parallel.
pub(super) fn write_runs(folder: &Folder, runs: &[Run]) -> Result<(), CliError> {
    runs.par_iter().try_for_each(|run| write_run(folder, run, &run.document(), &FormatArgs::default()))
}
