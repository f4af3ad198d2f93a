use clap::Args;

use super::error::Failure;
use super::terminal;
use trocar_base::names::shortened;
use trocar_base::warning::Code;
use trocar_document::counted;
use trocar_metrics::Declaration;
use trocar_report::{WIDTH, filled};
use trocar_scenario::{Fallback, KEYS, Key, KeyAt, SECTIONS, find_key, nearest_key, nearest_of, unit_of};
use trocar_studies::reference::declarations;

const EXAMPLES: &str = "\
Examples:
  trocar explain
  trocar explain missed-rupture
  trocar explain detector.threshold
  trocar explain detector
  trocar explain \"depth 2 s later\"
  trocar explain felt_contrast";

/// Explain a warning, a key, a section of keys or a metric.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct ExplainArgs {
    /// Code of a warning, key or section of a scenario, or name or printed label of a metric; without it, list all
    /// warnings
    #[arg(value_name = "CODE|KEY|SECTION|METRIC|LABEL")]
    word: Option<String>,
}

pub(super) fn run(args: &ExplainArgs) -> Result<(), Failure> {
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

fn explained(word: &str) -> Result<String, Failure> {
    let metric = |metric: &&Declaration| metric.key(1) == number_one(word) || metric.name == word;
    if let Some(code) = Code::parse(word) {
        Ok(format!("{word}\n{}\n{}", paragraph(code.meaning()), paragraph(code.explanation())))
    } else if let Some(key) = find_key(word) {
        Ok(of_key(&key))
    } else if let Some(metric) = declarations().find(metric) {
        Ok(of_metric(metric))
    } else if let Some(text) = of_label(word).or_else(|| of_section(word)).or_else(|| of_scope(word)) {
        Ok(text)
    } else {
        let codes = nearest_of(word, Code::ALL.iter().map(|code| code.word().to_owned()));
        let metrics = || nearest_of(word, declarations().map(|metric| metric.name.to_owned()));
        let labels = || nearest_of(word, declarations().map(|metric| metric.label.to_owned()));
        let nearest = codes.or_else(|| nearest_key(word).map(str::to_owned)).or_else(metrics).or_else(labels);
        let meant = nearest.map_or(String::new(), |nearest| format!("; did you mean {nearest}?"));
        Err(Failure::input(format!("there is no warning, key or metric {:?}{meant}", shortened(word))))
    }
}

fn number_one(word: &str) -> String {
    let mut parts = word.splitn(3, '_');
    match (parts.next(), parts.next(), parts.next()) {
        (Some(scope @ ("rupture" | "event")), Some(number), Some(name)) if number.parse::<u32>().is_ok() => {
            format!("{scope}_1_{name}")
        }
        _ => word.to_owned(),
    }
}

/// With or without the prefix of the scope, as in `rupture 2: detection delay`.
fn of_label(word: &str) -> Option<String> {
    let word = word.trim().to_lowercase();
    let (scope, label) = word.split_once(": ").unwrap_or(("", &word));
    let scope = scope.trim_end_matches(|c: char| c.is_ascii_digit() || c == ' ');
    let is_meant = |metric: &&Declaration| {
        let full = metric.full_label(1).to_lowercase();
        let name = full.split_once(": ").map_or("", |(scope, _)| scope.trim_end_matches(" 1"));
        metric.label.to_lowercase() == label && (scope.is_empty() || scope == name) || full == word
    };
    let all: Vec<String> = declarations().filter(is_meant).map(of_metric).collect();
    (!all.is_empty()).then(|| all.join("\n"))
}

fn of_section(word: &str) -> Option<String> {
    let word = word.trim().trim_start_matches('[').trim_end_matches(']');
    let (name, about) = SECTIONS.iter().find(|(name, _)| *name == word)?;
    let in_section = |key: &&Key| key.path.rsplit_once('.').is_some_and(|(section, _)| section == *name);
    let keys = KEYS.iter().filter(in_section).map(|key| format!("\n{}\n{}", key.path, paragraph(key.meaning)));
    Some(format!("[{name}]\n{}{}", paragraph(about), keys.collect::<String>()))
}

/// Such as `stability` or `link`.
fn of_scope(word: &str) -> Option<String> {
    let of_metric = |metric: &Declaration| format!("\n{}\n{}", metric.key(1), paragraph(metric.meaning));
    let scope = word.trim();
    let is_meant = |metric: &&Declaration| {
        let key = metric.key(1);
        key.strip_prefix(scope).is_some_and(|rest| rest.starts_with('_')) && key != metric.name
    };
    let all: Vec<String> = declarations().filter(is_meant).map(of_metric).collect();
    (!all.is_empty()).then(|| format!("{scope}: {}\n{}", counted(all.len() as u64, "metric"), all.concat()))
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

fn paragraph(text: &str) -> String {
    filled(text, WIDTH - 2, 0).iter().map(|line| format!("  {line}\n")).collect()
}
