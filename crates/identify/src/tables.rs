use std::collections::BTreeMap;
use std::fmt::Write as _;

use trocar_base::names::distinct;
use trocar_base::warning::Warning;
use trocar_document::{
    Cell, Digits, Document, Number, Section, Table, Unit, Verdict, json_of, shortest, show, significant,
};

use crate::actuator::Bounded;
use crate::file::{IdentificationFile, ParameterEntry};
use crate::whiteness::Whiteness;

/// A prediction with at least this fit supports the machine.
const GOOD_PERCENT: f64 = 90.0;

pub(crate) struct Reported {
    pub(crate) key: &'static str,
    pub(crate) name: &'static str,
    pub(crate) unit: String,
    pub(crate) bounded: Bounded,
}

pub(crate) struct Contents<'a> {
    pub(crate) verdict: Verdict,
    pub(crate) warnings: &'a [Warning],
    pub(crate) parameters: &'a [Reported],
    pub(crate) fits: Table,
    pub(crate) structures: Table,
    pub(crate) comparison: &'static str,
    pub(crate) names: Vec<String>,
    pub(crate) file: IdentificationFile<'a>,
}

pub(crate) fn document<'a>(contents: Contents<'_>) -> Document<'a> {
    let Contents { verdict, warnings, parameters, fits, structures, comparison, names, file } = contents;
    let mut of_parameters = Section::new("parameters", "Parameters");
    of_parameters.table(parameter_table(parameters));
    let mut of_fits = Section::new("fits", "Fits");
    of_fits.table(fits);
    of_fits.figures(names, vec![]);
    let mut of_structures = Section::new("structures", "Structures");
    of_structures.table(structures);
    of_structures.text(comparison);
    Document {
        name: "identification",
        title: format!("identification of the {}", file.machine),
        verdict,
        warnings: warnings.to_vec(),
        sections: vec![of_parameters, of_fits, of_structures],
        json: json_of(&file),
        ..Document::default()
    }
}

/// As in "moving mass 0.24 kg".
pub(crate) fn listed(parameters: &[Reported]) -> String {
    let value = |one: &Reported| {
        let (value, unit) = (one.bounded.value, one.unit.as_str());
        let value = match unit {
            "s" => show(Some(value), Unit::Second),
            "m" => show(Some(value), Unit::Metre),
            "1" => significant(value),
            _ => format!("{} {unit}", significant(value)),
        };
        format!("{} {value}", one.name)
    };
    parameters.iter().map(value).collect::<Vec<_>>().join(", ")
}

/// `trained` and `predicted` are mean fits in %; `others` are the predicted recordings with their fits.
pub(crate) fn fit_sentences(
    trained: Option<f64>,
    predicted: Option<f64>,
    others: &[(&str, Option<f64>)],
) -> Vec<String> {
    let worst = others.iter().min_by(|a, b| a.1.unwrap_or(f64::MIN).total_cmp(&b.1.unwrap_or(f64::MIN)));
    let percent = |fit: Option<f64>| fit.map_or_else(|| "no".to_owned(), |fit| format!("{fit:.1} %"));
    let mut sentences = match worst {
        None => vec![format!(
            "It follows the training recordings with a mean fit of {}. No recording tests it: give --predict.",
            percent(trained)
        )],
        Some((name, fit)) => vec![format!(
            "It predicts the recordings that were not used for training with a mean fit of {}, at worst {} ({name}); the training \
             recordings have {}.",
            percent(predicted),
            percent(*fit),
            percent(trained)
        )],
    };
    if worst.map_or(trained, |worst| worst.1).is_none_or(|fit| fit < GOOD_PERCENT) {
        sentences.push(
            "A fit below 90 % means that the machine has a part which this structure or these training recordings lack.".into(),
        );
    }
    sentences
}

pub(crate) fn doubts(parameters: &[Reported], mut whiteness: impl Iterator<Item = Option<Whiteness>>) -> Vec<String> {
    let mut doubts = vec![];
    let is_unknown = |one: &&Reported| one.bounded.low == 0.0 || !one.bounded.high.is_finite();
    let unknown: Vec<&str> = parameters.iter().filter(is_unknown).map(|one| one.name).collect();
    if !unknown.is_empty() {
        doubts.push(format!("The recordings cannot tell from zero: {}.", unknown.join(", ")));
    }
    if whiteness.any(|whiteness| whiteness.is_some_and(|whiteness| !whiteness.is_white())) {
        doubts.push(
            "The errors of the simulation are correlated in time: the machine has dynamics that the model lacks. The intervals allow for \
             the correlation, but not for parts that only other motions excite."
                .into(),
        );
    }
    doubts
}

fn parameter_table(parameters: &[Reported]) -> Table {
    let columns = [("parameter", "parameter"), ("value", "value"), ("low", "95 % from"), ("high", "to")];
    let mut table = Table::new("parameters", "Parameters", columns);
    for Reported { name, unit, bounded, .. } in parameters {
        let cell = |value: f64| match unit.as_str() {
            _ if !value.is_finite() => Cell::Undefined,
            "s" => Number::milliseconds(value).into(),
            "m" => Cell::of(Some(value), Unit::Metre),
            _ => Number::si(value, unit.clone()).into(),
        };
        table.row([(*name).into(), cell(bounded.value), cell(bounded.low), cell(bounded.high)]);
    }
    table
}

pub(crate) fn parameter_entries(parameters: &[Reported]) -> BTreeMap<&'static str, ParameterEntry> {
    let finite = |value: f64| value.is_finite().then_some(value);
    let entry = |one: &Reported| {
        let Bounded { value, low, high } = one.bounded;
        (one.key, ParameterEntry { value, low: finite(low), high: finite(high), unit: one.unit.clone() })
    };
    parameters.iter().map(entry).collect()
}

pub(crate) fn toml<'a>(machine: &str, parameters: &[Reported], training: impl Iterator<Item = &'a str>) -> String {
    let mut text = format!("# Identified by trocar {}.\n", env!("CARGO_PKG_VERSION"));
    for recording in training {
        let _ = writeln!(text, "# Training recording: {recording:?}");
    }
    let _ = writeln!(text, "[machine.{machine}]");
    for Reported { key, unit, bounded: Bounded { value, low, high }, .. } in parameters {
        let interval = if low.is_finite() && high.is_finite() {
            format!("95 % interval {low:.4e} to {high:.4e}")
        } else {
            "not determined by the recordings".to_owned()
        };
        let _ = writeln!(text, "{key} = {} # {unit}, {interval}", shortest(*value));
    }
    text
}

pub(crate) fn percent(value: Option<f64>, decimals: usize) -> Cell {
    value.map_or(Cell::Undefined, |value| Number::si(value, "%").digits(Digits::Decimals(decimals)).into())
}

/// The stems of the files, with a number if they repeat.
pub(crate) fn file_names<'a>(recordings: impl Iterator<Item = &'a str>) -> Vec<String> {
    let stem = |name: &str| {
        let stem = std::path::Path::new(name).file_stem();
        stem.map_or_else(|| "recording".into(), |stem| stem.to_string_lossy().into_owned())
    };
    distinct(&recordings.map(stem).collect::<Vec<_>>(), &[])
}

pub(crate) fn times(samples: usize, interval_s: f64) -> Vec<f64> {
    (0..samples).map(|sample| sample as f64 * interval_s).collect()
}
