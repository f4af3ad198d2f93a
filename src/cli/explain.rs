//! `trocar explain`.

use clap::Args;

use super::error::CliError;
use super::terminal;
use trocar_base::warning::Code;
use trocar_metrics::Declaration;
use trocar_report::{WIDTH, filled};
use trocar_scenario::{Fallback, KeyAt, find_key, nearest_key, nearest_of, unit_of};
use trocar_studies::reference::declarations;

const EXAMPLES: &str = "\
Examples:
  trocar explain
  trocar explain missed-rupture
  trocar explain detector.threshold
  trocar explain felt_contrast";

/// Explain a warning, a key or a metric.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct ExplainArgs {
    /// Code of a warning, key of a scenario, or name of a metric; without it, all warnings are listed
    #[arg(value_name = "CODE|KEY|METRIC")]
    word: Option<String>,
}

pub(super) fn run(args: &ExplainArgs) -> Result<(), CliError> {
    match &args.word {
        None => terminal::print(&list()),
        Some(word) => terminal::print(&explained(word)?),
    }
}

fn list() -> String {
    let mut text = String::new();
    for code in Code::ALL {
        text.push_str(&format!("{}\n{}", code.word(), paragraph(code.meaning())));
    }
    text
}

fn explained(word: &str) -> Result<String, CliError> {
    let metric = |metric: &&Declaration| metric.key(1) == number_one(word) || metric.name == word;
    if let Some(code) = Code::parse(word) {
        Ok(format!("{word}\n{}\n{}", paragraph(code.meaning()), paragraph(code.explanation())))
    } else if let Some(key) = find_key(word) {
        Ok(of_key(&key))
    } else if let Some(metric) = declarations().find(metric) {
        Ok(of_metric(metric))
    } else {
        let codes = nearest_of(word, Code::ALL.iter().map(|code| code.word().to_owned()));
        let metrics = || nearest_of(word, declarations().map(|metric| metric.name.to_owned()));
        let nearest = codes.or_else(|| nearest_key(word).map(str::to_owned)).or_else(metrics);
        Err(CliError::Unknown { word: word.to_owned(), nearest })
    }
}

/// Replaces the number of a rupture or event by 1.
fn number_one(word: &str) -> String {
    let mut parts = word.splitn(3, '_');
    match (parts.next(), parts.next(), parts.next()) {
        (Some(scope @ ("rupture" | "event")), Some(number), Some(name)) if number.parse::<u32>().is_ok() => {
            format!("{scope}_1_{name}")
        }
        _ => word.to_owned(),
    }
}

fn of_key(key: &KeyAt) -> String {
    let default = match key.fallback {
        Fallback::Value(value) => format!("Default: {}.", trocar_scenario::Value::from(value).to_toml()),
        Fallback::Derived(rule) => format!("Default: {rule}."),
        Fallback::Unset => "No default.".into(),
    };
    let unit = unit_of(&key.path).map_or(String::new(), |unit| format!(" Unit: {unit}."));
    let acts = key.acts_for.map_or(String::new(), |acts| format!(" Applies to {acts}."));
    let facts = format!("It must be {}. {default}{unit}{acts}", key.kind);
    format!("{}\n{}\n{}", key.path, paragraph(key.meaning), paragraph(&facts))
}

fn of_metric(metric: &Declaration) -> String {
    let unit = match metric.unit.si() {
        "" => String::new(),
        unit => format!(" Unit: {unit}."),
    };
    let facts = format!("In tables: {}.{unit} Better: {}.", metric.full_label(1), metric.better.word());
    format!("{}\n{}\n{}", metric.key(1), paragraph(metric.meaning), paragraph(&facts))
}

/// Returns an indented paragraph.
fn paragraph(text: &str) -> String {
    filled(text, WIDTH - 2, 0).iter().map(|line| format!("  {line}\n")).collect()
}
