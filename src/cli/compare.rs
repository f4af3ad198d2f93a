//! `trocar compare`.

use clap::Args;

use super::error::CliError;
use super::{OutputArgs, ScenarioArgs, run, terminal};
use crate::compare::{Comparison, Fact, paper_facts};
use crate::report::{Folder, comparison_csv, comparison_json, comparison_pictures, comparison_text, facts_text};

/// The pair that is compared when none is named.
const PAPER_PAIR: [&str; 2] = ["builtin:classical.toml", "builtin:augmented.toml"];

/// Compare scenarios.
#[derive(Debug, Args)]
pub(super) struct CompareArgs {
    /// Scenario files; with none, the paper's pair: builtin:classical.toml and builtin:augmented.toml
    #[arg(value_name = "SCENARIO")]
    scenarios: Vec<String>,
    #[command(flatten)]
    changes: ScenarioArgs,
    #[command(flatten)]
    output: OutputArgs,
}

pub(super) fn run(args: &CompareArgs) -> Result<(), CliError> {
    let is_paper_pair = args.scenarios.is_empty();
    let paths = if is_paper_pair { PAPER_PAIR.map(str::to_owned).to_vec() } else { args.scenarios.clone() };
    let scenarios = args.changes.load(&paths)?;
    let comparison = Comparison::of(scenarios)?;
    let facts = if is_paper_pair { paper_facts(&comparison) } else { None };
    let json = comparison_json(&comparison, facts.as_deref());
    write(&Folder::new(&args.output.out), &comparison, &json)?;
    if args.output.json {
        terminal::print(&json)
    } else if args.output.quiet {
        Ok(())
    } else {
        terminal::print(&text(args, &comparison, facts.as_deref()))
    }
}

fn write(folder: &Folder, comparison: &Comparison, json: &str) -> Result<(), CliError> {
    let files = || -> Result<(), CliError> {
        folder.write("comparison.json", json.as_bytes())?;
        folder.write("comparison.csv", comparison_csv(comparison).as_bytes())?;
        run::write_runs(folder, &comparison.runs)
    };
    let (files, pictures) = rayon::join(files, || comparison_pictures(folder, &comparison.runs));
    files?;
    pictures?;
    Ok(())
}

fn text(args: &CompareArgs, comparison: &Comparison, facts: Option<&[Fact]>) -> String {
    let mut text = comparison_text(comparison);
    if let Some(facts) = facts {
        text.push_str(&format!("\n{}", facts_text(facts)));
    } else if args.scenarios.is_empty() {
        text.push_str("\nthe paper's facts are not shown: they need two ruptures and an event\n");
    }
    let out = args.output.out.display();
    text.push_str(&format!("\nfigures: {out}/comparison.png, {out}/overlay.png; everything else: {out}\n"));
    text
}
