use clap::Args;
use clap::builder::PossibleValuesParser;

use super::compare::over_seeds;
use super::error::Failure;
use super::finish::Finish;
use super::warnings::Warnings;
use super::{OutputArgs, ScenarioArgs, progress, report, run};
use trocar_document::Study as _;
use trocar_scenario::{Scenario, Source};
use trocar_studies::compare::{
    FIXED_PERSONS, MAX_SEEDS, PERSONS, Person, SchemeReport, SchemeStudy, StrategyOptions, StrategyStudy,
};
use trocar_studies::run::seeds_without_effect;

const EXAMPLES: &str = "\
Examples:
  trocar strategies
  trocar strategies scenarios/sweeps/patients.toml
  trocar strategies --persons child,expert --patients 50 --seeds 2
  trocar strategies --schemes link/long-delay";

const SCENARIO: &str = "layers/skin-augmented";

const SEEDS: u64 = 10;

const MAX_PATIENTS: u64 = 100_000;

/// Compare the strategies against a rupture on one scenario.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES, mut_arg("out", |arg| arg.help(super::OUT_PER_COMMAND)))]
pub(super) struct StrategiesArgs {
    /// A scenario, or a sweep file whose points are the patients [default: layers/skin-augmented]
    #[arg(value_name = "SCENARIO")]
    scenario: Option<String>,
    /// Number of seeds of each patient and person [default: 10]; with --schemes: also run with N seeds
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(2..=MAX_SEEDS))]
    seeds: Option<u64>,
    /// Persons, or groups of people from which each patient gets another member
    ///
    /// attentive, distracted and practised are persons. adult, child and expert are groups, whose arms, grips,
    /// perception and reactions are drawn for every patient.
    #[arg(long, value_name = "WHO,...", value_delimiter = ',', value_parser = PossibleValuesParser::new(PERSONS.map(|person| person.name)))]
    persons: Vec<String>,
    /// Number of patients: the first N points of a sweep file, or N members drawn from each group of people
    #[arg(long, value_name = "N", default_value_t = 200, value_parser = clap::value_parser!(u64).range(1..=MAX_PATIENTS))]
    patients: u64,
    /// Compare the passivity schemes of the link instead: none, and each scheme that the architecture allows
    #[arg(long, requires = "scenario", conflicts_with_all = ["persons", "patients"])]
    schemes: bool,
    /// Also print the tables of all metrics; only with --schemes
    #[arg(long, requires = "schemes")]
    all: bool,
    /// Also write report.html into DIR/strategies; only with --schemes
    #[arg(long, requires = "schemes")]
    report: bool,
    #[command(flatten)]
    changes: ScenarioArgs,
    #[command(flatten)]
    output: OutputArgs,
}

pub(super) fn run(args: &StrategiesArgs) -> Result<(), Failure> {
    let source = Source::parse(args.scenario.as_deref().unwrap_or(SCENARIO));
    if args.schemes {
        return schemes(args, &source);
    }
    let chosen: Vec<&Person> = args.persons.iter().filter_map(|name| Person::named(name)).collect();
    let options = StrategyOptions {
        persons: if chosen.is_empty() { FIXED_PERSONS.to_vec() } else { chosen },
        patients: args.patients,
        seeds: args.seeds.unwrap_or(SEEDS),
    };
    let folder = args.output.destination().open("strategies", "strategies")?;
    let bar = progress::counter(args.output.quiet);
    bar.set_message("runs");
    let study = StrategyStudy::of(&source, &args.changes.settings, &options, |runs| bar.inc(runs))?;
    bar.finish_and_clear();
    Finish { output: &args.output, folder, all: false, report: None }.document(&study.document())
}

fn schemes(args: &StrategiesArgs, source: &Source) -> Result<(), Failure> {
    let warnings = Warnings::new(&args.output);
    let study = SchemeStudy::of(source, &args.changes.settings)?;
    let runs = &study.comparison.runs;
    let scenarios: Vec<Scenario> = runs.iter().map(|run| run.scenario.clone()).collect();
    warnings.print(&seeds_without_effect(&scenarios, args.seeds.unwrap_or(1)));
    let seeds = args.seeds.map(|seeds| over_seeds(&args.output, &scenarios, seeds)).transpose()?;
    let report = SchemeReport { study: &study, seeds: seeds.as_ref() };
    let document = report.document();
    warnings.print(&study.comparison.warnings());
    let folder = args.output.destination().open("strategies", "strategies")?;
    run::write_runs(&folder, runs)?;
    let flags = std::iter::once("--schemes".to_owned()).chain(report::seeds_flag(args.seeds));
    let again = || report::again("trocar strategies", &runs[..1], flags);
    Finish { output: &args.output, folder, all: args.all, report: args.report.then(again) }.document(&document)?;
    warnings.finish()
}
