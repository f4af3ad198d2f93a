use clap::Args;

use super::error::Failure;
use super::finish::Finish;
use super::warnings::Warnings;
use super::{OutputArgs, ScenarioArgs, progress, report, run};
use trocar_document::Study as _;
use trocar_report::html::{Again, command_line};
use trocar_scenario::Scenario;
use trocar_studies::compare::{Comparison, ComparisonReport, MAX_SEEDS, SeedStudy, paper_facts};
use trocar_studies::run::seeds_without_effect;

const PAPER_PAIR: [&str; 2] = ["paper/classical", "paper/augmented"];

const EXAMPLES: &str = "\
Examples:
  trocar compare                             the pair of the paper
  trocar compare layers/through-the-skin layers/skin-augmented
  trocar compare --seeds 200 --set sensor.force_noise_std_n=0.025";

/// Compare scenarios.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES, mut_arg("out", |arg| arg.help(super::OUT_PER_COMMAND)))]
pub(super) struct CompareArgs {
    /// Scenario files or shipped scenarios [default: paper/classical and paper/augmented, the pair of the paper]
    #[arg(value_name = "SCENARIO")]
    scenarios: Vec<String>,
    /// Also run every scenario with N seeds, starting at its own seed, and print medians and central 95 % intervals
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(2..=MAX_SEEDS))]
    seeds: Option<u64>,
    /// Print the table of all metrics, with all ruptures
    #[arg(long)]
    all: bool,
    /// Also write report.html into DIR/compare: one self-contained page with the scenarios, the metrics and their meaning,
    /// the events, and interactive charts of all runs
    #[arg(long)]
    report: bool,
    #[command(flatten)]
    changes: ScenarioArgs,
    #[command(flatten)]
    output: OutputArgs,
}

pub(super) fn run(args: &CompareArgs) -> Result<(), Failure> {
    let is_paper_pair = args.scenarios.is_empty();
    let paths = if is_paper_pair { PAPER_PAIR.map(str::to_owned).to_vec() } else { args.scenarios.clone() };
    let scenarios = args.changes.load(&paths)?;
    let folder = args.output.destination().open("compare", "compare")?;
    let warnings = Warnings::new(&args.output);
    warnings.print(&seeds_without_effect(&scenarios, args.seeds.unwrap_or(1)));
    let seeds = args.seeds.map(|seeds| over_seeds(&args.output, &scenarios, seeds)).transpose()?;
    let comparison = Comparison::of(scenarios)?;
    let facts = if is_paper_pair { paper_facts(&comparison) } else { None };
    let report = ComparisonReport { comparison: &comparison, facts: facts.as_deref(), seeds: seeds.as_ref() };
    let (runs, document) = (&comparison.runs, report.document());
    run::write_runs(&folder, runs)?;
    warnings.print(&comparison.warnings());
    let again = || {
        let again = report::again("trocar compare", runs, report::seeds_flag(args.seeds));
        if is_paper_pair && !names_files(args) {
            Again { line: command(args), note: "trocar includes these scenarios.", ..again }
        } else {
            again
        }
    };
    Finish { output: &args.output, folder, all: args.all, report: args.report.then(again) }.document(&document)?;
    warnings.finish()
}

/// True if a setting names a file, which other machines may not have.
fn names_files(args: &CompareArgs) -> bool {
    args.changes
        .settings
        .iter()
        .any(|setting| setting.trim_start().starts_with("recording.") || setting.contains("file"))
}

fn command(args: &CompareArgs) -> String {
    let seeds = args.seeds.map(|seeds| ["--seeds".to_owned(), seeds.to_string()]);
    let flags = report::set_flags(&args.changes.settings).chain(seeds.into_iter().flatten());
    command_line(["compare".to_owned()].into_iter().chain(flags).chain(["--report".to_owned()]))
}

pub(super) fn over_seeds(output: &OutputArgs, scenarios: &[Scenario], seeds: u64) -> Result<SeedStudy, Failure> {
    let runs = usize::try_from(seeds).unwrap_or(usize::MAX).saturating_mul(scenarios.len());
    let bar = progress::bar(runs, output.quiet);
    bar.set_message("seeds");
    let study = SeedStudy::of(scenarios, seeds, || bar.inc(1));
    bar.finish_and_clear();
    Ok(study?)
}
