//! The reference pages that are generated from the declarations; `BLESS=1` renews them.

use std::fmt::Write as _;

use trocar::reference::{metrics_markdown, trace_columns_markdown};
use trocar::scenario::{Constant, Fallback, KEYS, Key, Kind, NAME_RULE, SECTIONS, Value, shipped_questions, unit_of};

use trocar::tissue::{LAYER_KEYS, LAYER_LIST, TissueSettings};
use trocar::warning::Code;

use super::GENERATED;
use crate::support::assert_file;
use crate::support::test_folder::TestFolder;

fn assert_page(name: &str, text: &str) {
    assert_file(&format!("docs/src/reference/{name}"), &format!("{GENERATED}\n{text}"));
}

/// Escapes a text for a cell of a table.
fn cell(text: &str) -> String {
    text.replace('|', "\\|")
}

/// Returns the required value of a key, with its unit.
fn requirement(key: &Key) -> String {
    let unit = unit_of(key.path).filter(|_| matches!(key.kind, Kind::Number(_) | Kind::Numbers));
    let must = key.kind.to_string();
    match unit {
        // A range with a reason already contains the unit.
        Some(unit) if !must.contains(&format!(" {unit} (")) => format!("{must}, in {unit}"),
        _ => must,
    }
}

fn row(key: &Key) -> String {
    let name = key.path.rsplit('.').next().unwrap_or(key.path);
    let default = match key.fallback {
        Fallback::Value(Constant::Text("")) | Fallback::Unset => "—".into(),
        Fallback::Value(value) => format!("`{}`", Value::from(value).to_toml()),
        Fallback::Derived(rule) => rule.into(),
    };
    let acts = key.acts_for.map_or(String::new(), |acts| format!(" *Applies to {acts}.*"));
    format!("| `{name}` | {} | {} | {}{acts} |\n", cell(&requirement(key)), cell(&default), cell(key.meaning))
}

#[test]
fn the_page_of_the_keys_agrees_with_the_declarations() {
    let mut text = String::from(
        "# Keys\n\nEvery key of a scenario. A number may be written as a string with a unit: `\"30ms\"`. \
         *Applies to* names the values of another key for which a key has an effect.\n",
    );
    let sections = std::iter::once(("", "Keys at the top level.")).chain(SECTIONS);
    for (section, about) in sections {
        let of_section = |path: &str| path.rsplit_once('.').map_or(section.is_empty(), |(parent, _)| parent == section);
        let keys: Vec<_> = KEYS.iter().filter(|key| of_section(key.path)).collect();
        if keys.is_empty() {
            continue;
        }
        let title = if section.is_empty() { "General".into() } else { format!("\\[{section}\\]") };
        write!(text, "\n## {title}\n\n{about}\n\n| key | value | default | meaning |\n|---|---|---|---|\n")
            .expect("text");
        keys.into_iter().for_each(|key| text.push_str(&row(key)));
    }
    let default = |word: &str| {
        let names: Vec<_> = TissueSettings::default_layers(word).iter().map(|(name, _)| format!("`{name}`")).collect();
        names.join(", ")
    };
    let (of_layers, of_tearing) = (default("layers"), default("tearing"));
    write!(
        text,
        "\n## \\[\\[{LAYER_LIST}\\]\\]\n\nA layer, from the surface down. Elsewhere a key is addressed by the name of the layer, as in \
         `--set {LAYER_LIST}.dura.thickness_m=5e-4`. A list replaces the list of a base. Without a list the layers are {of_layers} \
         for tissue.kind = layers, which have values of their own, and {of_tearing} for tissue.kind = tearing.\n\n| key | value | default | meaning |\n|---|---|---|---|\n\
         | `name` | {NAME_RULE} | — | Name of the layer. |\n"
    )
    .expect("text");
    LAYER_KEYS.iter().for_each(|key| text.push_str(&row(key)));
    assert_page("keys.md", &text);
}

#[test]
fn the_page_of_the_metrics_agrees_with_the_catalogue() {
    let text = format!(
        "# Metrics\n\nEvery metric, under one name in tables, CSV, JSON, sweeps, pages and Python. `N` counts from 1. A value that \
         does not exist is `null` in JSON and empty in CSV.\n\n{}",
        metrics_markdown()
    );
    assert_page("metrics.md", &text);
}

#[test]
fn the_page_of_the_columns_agrees_with_the_trace() {
    let text =
        format!("# Trace columns\n\nThe columns of `trace.csv`, one row per tick.\n\n{}", trace_columns_markdown());
    assert_page("columns.md", &text);
}

#[test]
fn the_page_of_the_warnings_agrees_with_their_declarations() {
    let mut text = String::from(
        "# Warnings\n\nA warning has a code, a message, the key, column or flag that it concerns, and a remedy. The \
         terminal, the JSON and the reports of runs, comparisons, recordings and stability, and Python (`warnings.warn`, with a \
         class for each code) show the same ones. `trocar explain CODE` \
         prints the entry of this page. `--deny-warnings` makes a command with a warning exit with code 1.\n",
    );
    for code in Code::ALL {
        write!(text, "\n## {}\n\n{}\n\n{}\n", code.word(), code.meaning(), code.explanation()).expect("text");
    }
    assert_page("warnings.md", &text);
}

#[test]
fn the_page_of_the_scenarios_lists_their_questions() {
    let mut text = String::from("# Shipped scenarios\n\n`trocar scenarios show NAME` prints one of them.\n");
    let mut folder = "";
    for (name, question) in shipped_questions() {
        let name = name.trim_end_matches(".toml");
        let (of, _) = name.rsplit_once('/').unwrap_or(("", name));
        if of != folder {
            folder = of;
            write!(text, "\n## {folder}\n\n| name | question |\n|---|---|\n").expect("text");
        }
        writeln!(text, "| `{name}` | {} |", cell(question)).expect("text");
    }
    assert_page("scenarios.md", &text);
}

#[test]
fn the_page_of_the_commands_agrees_with_their_help() {
    let folder = TestFolder::new();
    let help = folder.good(&["--help"]);
    let mut text = format!("# Commands\n\nThe help of trocar, and that of each command.\n\n```text\n{help}```\n");
    for name in folder.commands() {
        write!(text, "\n## {name}\n\n```text\n{}```\n", folder.good(&[&name, "--help"])).expect("text");
    }
    assert_page("commands.md", &text);
}
