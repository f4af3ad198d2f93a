use std::collections::HashMap;

use schemars::JsonSchema;
use serde::Serialize;

use trocar_document::{Cell, Document, Section, Table, Verdict, command_line, counted, json_of, plain};
use trocar_recording::{Quantity, Roles, Signal};
use trocar_scenario::parse_quantity;

pub fn signals_document(file: &str, signals: &[Signal]) -> Document<'static> {
    let times = times(signals);
    let mut section = Section::new("signals", "Signals");
    section.table(table(signals));
    let others = signals.len().saturating_sub(MAX_ROWS);
    if others > 0 {
        section.text(format!("The file has {} more, which --json lists.", counted(others as u64, "signal")));
    }
    let mut of_command = Section::new("command", "Command");
    choices(signals).into_iter().for_each(|line| of_command.text(line));
    let command = command(file, signals);
    of_command.blocks.push(trocar_document::Block::Command(command.clone()));
    Document {
        name: "signals",
        title: file.to_owned(),
        verdict: Verdict { sentences: vec![counted(signals.len() as u64, "signal")], left_out: vec![] },
        sections: vec![section, of_command],
        json: json_of(&SignalsFile {
            trocar_version: env!("CARGO_PKG_VERSION"),
            file,
            signals: signals.iter().map(|signal| object(signal, &times)).collect(),
            roles_are_unique: Roles::of(signals).are_unique(),
            command,
        }),
        ..Document::default()
    }
}

const MAX_ROWS: usize = 200;
const MAX_CHARACTERS: usize = 80;

const MAX_LISTED: usize = 12;

/// First time with each number of samples.
type Times<'a> = HashMap<usize, &'a Signal>;

fn times(signals: &[Signal]) -> Times<'_> {
    let times = signals.iter().filter(|signal| signal.role == Some(Quantity::Time));
    times.fold(HashMap::new(), |mut times, time| {
        times.entry(time.samples).or_insert(time);
        times
    })
}

fn rate_hz(signal: &Signal, times: &Times<'_>) -> Option<f64> {
    let time = times.get(&signal.samples)?;
    let unit = time.unit.as_deref().unwrap_or("s");
    let duration_s = time.increase? * parse_quantity(&format!("1 {unit}"), "s").unwrap_or(1.0);
    (duration_s > 0.0).then(|| (signal.samples - 1) as f64 / duration_s)
}

/// A capital word is a missing signal.
fn command(file: &str, signals: &[Signal]) -> String {
    let roles = Roles::of(signals);
    let mut words = vec!["detect".to_owned(), file.to_owned()];
    for quantity in Quantity::ALL {
        let column = match roles.first(quantity) {
            Some(index) => signals[index].column(),
            None if quantity == Quantity::Velocity => continue,
            None => quantity.name().to_uppercase(),
        };
        words.extend([format!("--{}", quantity.name()), column]);
    }
    command_line(words)
}

fn table(signals: &[Signal]) -> Table {
    let has_labels = signals.iter().any(|signal| signal.label.is_some());
    let columns = ["signal", "role", "shape", "unit", "rate", "range"].into_iter().chain(has_labels.then_some("text"));
    let mut table = Table::new("signals", "Signals", columns.map(|column| (column, column))).of_text();
    let times = times(signals);
    for signal in signals.iter().take(MAX_ROWS) {
        let text = |text: Option<&str>| text.map_or(Cell::Undefined, Cell::from);
        let shape: Vec<String> = signal.shape.iter().map(usize::to_string).collect();
        let range = signal.range.map_or("—".into(), |(low, high)| format!("{} to {}", plain(low), plain(high)));
        let undefined = if signal.undefined == 0 { String::new() } else { format!(", {} undefined", signal.undefined) };
        let cells = [
            shortened(&signal.name).into(),
            text(signal.role.map(Quantity::name)),
            shape.join(" x ").into(),
            text(signal.unit.as_deref()),
            Cell::si(rate_hz(signal, &times), "Hz"),
            format!("{range}{undefined}").into(),
        ];
        table.row(cells.into_iter().chain(has_labels.then(|| signal.label.clone().unwrap_or_default().into())));
    }
    table
}

fn shortened(name: &str) -> String {
    match name.char_indices().nth(MAX_CHARACTERS) {
        Some((end, _)) => format!("{}…", &name[..end]),
        None => name.to_owned(),
    }
}

fn listed<'a>(signals: impl ExactSizeIterator<Item = &'a Signal>) -> String {
    let others = signals.len().saturating_sub(MAX_LISTED);
    let mut names: Vec<String> = signals.take(MAX_LISTED).map(|signal| shortened(&signal.name)).collect();
    if others > 0 {
        names.push(format!("and {others} more"));
    }
    names.join(", ")
}

fn choices(signals: &[Signal]) -> Vec<String> {
    let roles = Roles::of(signals);
    let of = |quantity: Quantity| match roles.candidates[quantity as usize].as_slice() {
        [] if quantity != Quantity::Velocity => Some(unknown(quantity, signals)),
        [_, others @ ..] if !others.is_empty() => {
            Some(format!("{}: or {}", quantity.name(), listed(others.iter().map(|index| &signals[*index]))))
        }
        _ => None,
    };
    Quantity::ALL.into_iter().filter_map(of).collect()
}

fn unknown(quantity: Quantity, signals: &[Signal]) -> String {
    let (name, word) = (quantity.name(), quantity.name().to_uppercase());
    let of_role = |signal: &&Signal| signal.role == Some(quantity);
    if let Some((signal, (low, high))) = signals
        .iter()
        .filter(of_role)
        .find(|signal| signal.needs_unit())
        .and_then(|signal| Some((signal, signal.range?)))
    {
        let (low, high, units) = (plain(low), plain(high), quantity.units());
        return format!(
            "{name}: '{}' states no unit, and its range, {low} to {high}, is hardly in {}; give its unit after a colon ({units})",
            shortened(&signal.name),
            quantity.unit()
        );
    }
    if let Some(signal) = signals.iter().filter(of_role).find(|signal| signal.undefined > 0) {
        return format!(
            "{name}: {} of {} samples of '{}' are no numbers",
            signal.undefined,
            signal.samples,
            shortened(&signal.name)
        );
    }
    let rate = if quantity == Quantity::Time { ", or give --rate HZ instead of --time" } else { "" };
    format!("{name}: no name or unit shows it; choose a signal for {word}{rate}")
}

/// The signals of a file, which `trocar detect --list --json` prints.
#[derive(Debug, Serialize, JsonSchema)]
pub struct SignalsFile<'a> {
    /// Version of trocar.
    trocar_version: &'static str,
    /// The path of the file as the user gave it.
    file: &'a str,
    /// The signals, in the order of the file.
    signals: Vec<ListedSignal<'a>>,
    /// True if time, position and force have exactly one candidate each.
    roles_are_unique: bool,
    /// The command that detects in the file; a word in capitals stands for a missing signal.
    command: String,
}

/// A signal of a file.
#[derive(Debug, Serialize, JsonSchema)]
struct ListedSignal<'a> {
    /// Its name.
    name: &'a str,
    /// The label of the signal in the file, if any.
    label: Option<&'a str>,
    /// Its unit, if the file states it.
    unit: Option<&'a str>,
    /// Its dimensions.
    shape: &'a [usize],
    /// Number of samples.
    samples: usize,
    /// Number of samples without a value.
    undefined: usize,
    /// Its sampling rate in Hz, from the first time signal with as many samples.
    rate_hz: Option<f64>,
    /// Its minimum, in its unit.
    min: Option<f64>,
    /// Its maximum, in its unit.
    max: Option<f64>,
    /// The probable quantity: `time`, `position`, `velocity` or `force`.
    role: Option<&'static str>,
    /// The column that selects the signal on the command line.
    column: String,
}

fn object<'a>(signal: &'a Signal, times: &Times<'_>) -> ListedSignal<'a> {
    ListedSignal {
        name: &signal.name,
        label: signal.label.as_deref(),
        unit: signal.unit.as_deref(),
        shape: &signal.shape,
        samples: signal.samples,
        undefined: signal.undefined,
        rate_hz: rate_hz(signal, times),
        min: signal.range.map(|(low, _)| low),
        max: signal.range.map(|(_, high)| high),
        role: signal.role.map(Quantity::name),
        column: signal.column(),
    }
}
