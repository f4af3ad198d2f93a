//! `trocar compare`.

use clap::Args;
use clap::builder::PossibleValuesParser;

use super::error::CliError;
use super::finish::Finish;
use super::warnings::Warnings;
use super::{OutputArgs, ScenarioArgs, progress, report, run, terminal};
use trocar_document::Study as _;
use trocar_report::html::{Again, command_line};
use trocar_report::{
    Animation, PictureError, runs_chart, strategies_csv, strategies_json, strategies_picture, strategies_text,
};
use trocar_scenario::{Scenario, Source};
use trocar_studies::compare::{
    Comparison, ComparisonReport, FIXED_PERSONS, MAX_SEEDS, PERSONS, Person, SchemeStudy, SeedStudy, StrategyOptions,
    StrategyStudy, paper_facts,
};
use trocar_studies::run::{Run, seeds_without_effect};

/// The default pair.
const PAPER_PAIR: [&str; 2] = ["paper/classical", "paper/augmented"];

const EXAMPLES: &str = "\
Examples:
  trocar compare                             the pair of the paper
  trocar compare layers/through-the-skin layers/skin-augmented
  trocar compare --seeds 200 --set sensor.force_noise_std_n=0.025
  trocar compare --schemes link/long-delay
  trocar compare --strategies scenarios/sweeps/patients.toml
  trocar compare --strategies --persons child,expert --patients 50 --seeds 2";

/// The default scenario of a comparison of strategies.
const STRATEGIES_SCENARIO: &str = "layers/skin-augmented";

/// Seeds of a comparison of strategies without --seeds.
const STRATEGIES_SEEDS: u64 = 10;

/// Largest number of patients of a comparison of strategies.
const MAX_PATIENTS: u64 = 100_000;

/// Compare scenarios.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
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
    /// Compare one scenario without a passivity scheme and with each: force, position, energy, felt impedance, overshoot, withdrawal
    #[arg(long)]
    schemes: bool,
    /// Compare the strategies against a rupture on one scenario, or on the patients of a sweep file, over persons and --seeds
    /// seeds (default 10): excess advance, what the person notices, and what a false alarm costs; default: layers/skin-augmented
    #[arg(long, conflicts_with_all = ["schemes", "all", "report"])]
    strategies: bool,
    /// With --strategies: the persons, or groups of people of which each patient has another member
    ///
    /// attentive, distracted and practised are persons; adult, child and expert are groups, whose arms, grips, perception and
    /// reactions are drawn for every patient.
    #[arg(long, value_name = "WHO,...", value_delimiter = ',', value_parser = PossibleValuesParser::new(PERSONS.map(|person| person.name)), requires = "strategies")]
    persons: Vec<String>,
    /// With --strategies and a sweep file: take its first N points as patients; with groups of people: draw N members
    #[arg(long, value_name = "N", default_value_t = 200, value_parser = clap::value_parser!(u64).range(1..=MAX_PATIENTS), requires = "strategies")]
    patients: u64,
    /// Also write report.html into DIR: one self-contained page with the scenarios, the metrics and their meaning, the events, and
    /// interactive charts of all runs
    #[arg(long)]
    report: bool,
    #[command(flatten)]
    changes: ScenarioArgs,
    #[command(flatten)]
    output: OutputArgs,
}

pub(super) fn run(args: &CompareArgs) -> Result<(), CliError> {
    if args.schemes {
        return run_schemes(args);
    }
    if args.strategies {
        return run_strategies(args);
    }
    let is_paper_pair = args.scenarios.is_empty();
    let paths = if is_paper_pair { PAPER_PAIR.map(str::to_owned).to_vec() } else { args.scenarios.clone() };
    let scenarios = args.changes.load(&paths)?;
    let warnings = Warnings::new(&args.output);
    warnings.print(&seeds_without_effect(&scenarios, args.seeds.unwrap_or(1)));
    let seeds = args.seeds.map(|seeds| over_seeds(args, &scenarios, seeds)).transpose()?;
    let comparison = Comparison::of(scenarios)?;
    let facts = if is_paper_pair { paper_facts(&comparison) } else { None };
    let told = ComparisonReport { comparison: &comparison, facts: facts.as_deref(), seeds: seeds.as_ref() };
    let is_shipped = is_paper_pair && !names_files(args);
    finish(args, &told, is_shipped, &warnings)?;
    warnings.finish()
}

/// Writes, draws and prints a comparison.
fn finish(
    args: &CompareArgs,
    told: &ComparisonReport<'_>,
    is_shipped: bool,
    warnings: &Warnings,
) -> Result<(), CliError> {
    let runs = &told.comparison.runs;
    let folder = args.output.folder();
    let document = told.document();
    let animation = Animation::of(&runs.iter().collect::<Vec<_>>());
    run::write_runs(&folder, runs)?;
    if let Some(animation) = &animation {
        folder.write("animation.png", &animation.png().map_err(PictureError::from)?)?;
    }
    warnings.print(&told.comparison.warnings());
    if !args.output.json && !args.output.quiet {
        terminal::draw(|| runs_chart(runs))?;
    }
    let again = || Again {
        command: "trocar compare",
        files: runs.iter().map(|run| (format!("{}.toml", run.scenario.name), run.scenario.echo())).collect(),
        line: if is_shipped { command(args) } else { command_of_files(args, runs) },
        animation,
    };
    Finish { output: &args.output, folder, all: args.all, report: args.report.then(again) }.document(&document)
}

/// Returns the command that reproduces the comparison of files that a report names.
fn command_of_files(args: &CompareArgs, runs: &[Run]) -> String {
    let files = runs.iter().map(|run| format!("{}.toml", run.scenario.name));
    let seeds = args.seeds.map(|seeds| ["--seeds".to_owned(), seeds.to_string()]);
    let flags = seeds.into_iter().flatten().chain(["--report".to_owned()]);
    command_line(["compare".to_owned()].into_iter().chain(files).chain(flags))
}

/// Compares one scenario with every passivity scheme.
fn run_schemes(args: &CompareArgs) -> Result<(), CliError> {
    let [path] = &args.scenarios[..] else {
        return Err(CliError::OneScenario { given: args.scenarios.len() });
    };
    let warnings = Warnings::new(&args.output);
    let study = SchemeStudy::of(&Source::parse(path), &args.changes.settings)?;
    let scenarios: Vec<Scenario> = study.comparison.runs.iter().map(|run| run.scenario.clone()).collect();
    warnings.print(&seeds_without_effect(&scenarios, args.seeds.unwrap_or(1)));
    let seeds = args.seeds.map(|seeds| over_seeds(args, &scenarios, seeds)).transpose()?;
    let told = ComparisonReport { comparison: &study.comparison, facts: None, seeds: seeds.as_ref() };
    finish(args, &told, false, &warnings)?;
    warnings.finish()
}

/// Compares the strategies against a rupture.
fn run_strategies(args: &CompareArgs) -> Result<(), CliError> {
    let path = match &args.scenarios[..] {
        [] => STRATEGIES_SCENARIO,
        [path] => path,
        all => return Err(CliError::OneScenarioOfStrategies { given: all.len() }),
    };
    let chosen: Vec<&Person> = args.persons.iter().filter_map(|name| Person::named(name)).collect();
    let options = StrategyOptions {
        persons: if chosen.is_empty() { FIXED_PERSONS.to_vec() } else { chosen },
        patients: args.patients,
        seeds: args.seeds.unwrap_or(STRATEGIES_SEEDS),
    };
    let bar = progress::counter(args.output.quiet);
    bar.set_message("runs");
    let study = StrategyStudy::of(&Source::parse(path), &args.changes.settings, &options, |runs| bar.inc(runs))?;
    bar.finish_and_clear();
    let folder = args.output.folder();
    let json = strategies_json(&study);
    folder.write("strategies.json", json.as_bytes())?;
    folder.write("strategies.csv", strategies_csv(&study).as_bytes())?;
    let is_drawn = strategies_picture(&folder, &study)?;
    if args.output.json {
        terminal::print(&json)?;
    } else if !args.output.quiet {
        let out = args.output.out.display();
        let file = folder.figures().shown("strategies");
        let figure = if is_drawn { format!("figure: {out}/{file}; ") } else { String::new() };
        terminal::print(&format!("{}\n{figure}all files: {out}\n", strategies_text(&study)))?;
    }
    Ok(())
}

/// Returns whether a setting names a file of this machine.
fn names_files(args: &CompareArgs) -> bool {
    args.changes
        .settings
        .iter()
        .any(|setting| setting.trim_start().starts_with("recording.") || setting.contains("file"))
}

/// Returns the command that reproduces the comparison of the shipped pair.
fn command(args: &CompareArgs) -> String {
    let seeds = args.seeds.map(|seeds| ["--seeds".to_owned(), seeds.to_string()]);
    let flags = report::set_flags(&args.changes.settings).chain(seeds.into_iter().flatten());
    command_line(["compare".to_owned()].into_iter().chain(flags).chain(["--report".to_owned()]))
}

fn over_seeds(args: &CompareArgs, scenarios: &[Scenario], seeds: u64) -> Result<SeedStudy, CliError> {
    let runs = usize::try_from(seeds).unwrap_or(usize::MAX).saturating_mul(scenarios.len());
    let bar = progress::bar(runs, args.output.quiet);
    bar.set_message("seeds");
    let study = SeedStudy::of(scenarios, seeds, || bar.inc(1));
    bar.finish_and_clear();
    Ok(study?)
}
