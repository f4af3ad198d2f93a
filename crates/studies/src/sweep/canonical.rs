//! The text of all inputs: equal texts mean equal results.

use std::fmt::Write as _;

use sha2::{Digest, Sha256};

use super::columns::Column;
use super::correlation::Correlation;
use super::design::Design;
use trocar_base::hexadecimal::hexadecimal;
use trocar_scenario::{OperatorSpec, Scenario, TissueSpec};

/// `signals` is a hash.
pub(crate) fn resolved_toml(scenario: &Scenario, signals: Sha256) -> String {
    let mut text = String::new();
    let _ = write!(
        text,
        "\n[resolved]\ntrocar_version = \"{}\"\nsignals_sha256 = \"{}\"\n",
        env!("CARGO_PKG_VERSION"),
        hexadecimal(&signals.finalize()),
    );
    let echo = scenario.echo();
    let mut is_in_section = false;
    // A section for each layer.
    let mut in_list = None;
    for line in echo.lines() {
        if let Some(list) = line.strip_prefix("[[").and_then(|line| line.strip_suffix("]]")) {
            in_list = Some(list);
            continue;
        }
        if let Some(name) = in_list.and(line.strip_prefix("name = ")) {
            let _ = write!(text, "\n[resolved.{}.{}]\n", in_list.unwrap_or_default(), name.trim_matches('"'));
            in_list = None;
            continue;
        }
        // A file is identified by its content, on any machine. The seeds are part of the design.
        let is_apart = ["file = ", "delays_file = ", "seed = "].iter().any(|key| line.starts_with(key));
        if let Some(section) = line.strip_prefix('[') {
            is_in_section = true;
            let _ = write!(text, "\n[resolved.{section}\n");
        } else if is_in_section && !line.is_empty() && !is_apart {
            let _ = writeln!(text, "{line}");
        }
    }
    text
}

pub(crate) fn sha256(bytes: &[u8]) -> String {
    hexadecimal(&Sha256::digest(bytes))
}

pub(super) fn design_toml(design: &Design) -> String {
    let names = |columns: Vec<&Column>| {
        let names: Vec<_> = columns.iter().map(|column| format!("{:?}", column.name)).collect();
        format!("[{}]", names.join(", "))
    };
    let seeds = match &design.listed_seeds {
        Some(seeds) => format!("seeds = {seeds:?}"),
        None => format!("seeds = {}\nfirst_seed = {}", design.seeds, design.first_seed),
    };
    let question = design.question.as_ref().map(|text| format!("question = {}\n", toml::Value::String(text.clone())));
    let mut text = format!(
        "name = {}\n{}{seeds}\nmetrics = {}\nfocus = {}\ncsv = {}\n\n[design]\nkind = \"{}\"\n",
        toml::Value::String(design.name.clone()),
        question.unwrap_or_default(),
        names(design.columns.iter().collect()),
        names(design.focus.iter().map(|index| &design.columns[*index]).collect()),
        design.csv,
        design.scheme.word(),
    );
    if let Some((points, seed)) = design.scheme.points_and_seed() {
        let _ = write!(text, "points = {points}\nseed = {seed}\n");
    }
    if !design.axes.is_empty() {
        text.push_str("\n[axes]\n");
    }
    for axis in &design.axes {
        let _ = writeln!(text, "{} = {}", axis.key.path, axis.to_toml());
    }
    for Correlation { name, axes, coefficient } in &design.correlations {
        let paths: Vec<_> = axes.iter().map(|axis| format!("{:?}", design.axes[*axis].key.path)).collect();
        let coefficient = toml::Value::Float(*coefficient);
        let _ = write!(text, "\n[correlations.{name}]\naxes = [{}]\ncoefficient = {coefficient}\n", paths.join(", "));
    }
    text
}

pub(crate) fn hash_signals(scenario: &Scenario, hash: &mut Sha256) {
    let mut numbers = |numbers: &[f64]| {
        hash.update((numbers.len() as u64).to_le_bytes());
        numbers.iter().for_each(|number| hash.update(number.to_bits().to_le_bytes()));
    };
    if let OperatorSpec::Recording(positions) = &scenario.operator {
        numbers(positions);
    }
    match &scenario.tissue {
        TissueSpec::Recording { force_n, .. } => numbers(force_n),
        TissueSpec::Depth { curves, .. } => curves.tables_n().iter().for_each(|table| numbers(table)),
        TissueSpec::Model(_) => {}
    }
    hash.update(format!("{:?} {:?}", scenario.forward_schedule, scenario.backward_schedule));
}
