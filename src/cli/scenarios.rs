use clap::{Args, Subcommand};
use schemars::JsonSchema;
use serde::Serialize;

use super::error::Failure;
use super::terminal;
use trocar_document::{json_of, to_json};
use trocar_report::{WIDTH, filled};
use trocar_scenario::{Source, shipped_questions};

const EXAMPLES: &str = "\
Examples:
  trocar scenarios
  trocar scenarios show layers/epidural > my.toml";

/// List the shipped scenarios.
#[derive(Debug, Args)]
#[command(args_conflicts_with_subcommands = true, after_help = EXAMPLES)]
pub(super) struct ScenariosArgs {
    #[command(subcommand)]
    action: Option<Action>,
    /// Print the name, question and path of each as JSON
    #[arg(long)]
    json: bool,
}

#[derive(Debug, Subcommand)]
enum Action {
    /// Print the text of a scenario, for reading or copying
    #[command(after_help = "Example:\n  trocar scenarios show layers/epidural > my.toml")]
    Show {
        /// A shipped scenario, such as layers/epidural, or a scenario file
        #[arg(value_name = "SCENARIO")]
        name: String,
    },
}

/// A shipped scenario.
#[derive(Serialize, JsonSchema)]
pub(super) struct ShippedScenario {
    /// The name that commands accept.
    name: String,
    /// The question that the scenario answers.
    question: &'static str,
    /// The path for `base` in a scenario file.
    path: String,
}

pub(super) fn run(args: &ScenariosArgs) -> Result<(), Failure> {
    match &args.action {
        Some(Action::Show { name }) => terminal::print(&Source::parse(name).read()?),
        None if args.json => {
            let entry = |(path, question)| {
                let (folder, name) = parts(path);
                ShippedScenario { name: format!("{folder}/{name}"), question, path: format!("builtin:{path}") }
            };
            terminal::print(&to_json(&json_of(&shipped_questions().map(entry).collect::<Vec<_>>())))
        }
        None => terminal::print(&list()),
    }
}

fn parts(path: &str) -> (&str, &str) {
    path.trim_end_matches(".toml").split_once('/').unwrap_or(("", path))
}

fn list() -> String {
    let widest = shipped_questions().map(|(path, _)| parts(path).1.len()).max().unwrap_or(0);
    let mut text = String::new();
    let mut here = "";
    for (path, question) in shipped_questions() {
        let (folder, name) = parts(path);
        if folder != here {
            here = folder;
            text.push_str(&format!("{folder}/\n"));
        }
        let mut label = name;
        for line in filled(question, WIDTH - widest - 4, 0) {
            text.push_str(&format!("  {label:widest$}  {line}\n"));
            label = "";
        }
    }
    text + "\nWrite a scenario as folder/name, as in\n\
            \x20 trocar run layers/skin-augmented\n\
            \x20 trocar compare paper/classical paper/augmented\n\
            \x20 trocar scenarios show layers/epidural\n"
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_list_is_complete_and_narrow() {
        let text = list();
        assert!(text.lines().all(|line| line.chars().count() <= WIDTH), "{text}");
        assert!(shipped_questions().all(|(path, _)| text.contains(&format!("\n  {} ", parts(path).1))), "{text}");
    }
}
