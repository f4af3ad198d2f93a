//! The signals of a file, as text and as JSON.

use serde_json::{Value as Json, json};

use crate::Table;
use crate::html::command_line;
use trocar_document::{plain, significant};
use trocar_recording::{Quantity, Roles, Signal};
use trocar_scenario::parse_quantity;

/// Returns the sampling rate of a signal in Hz: that of the first time with as many samples.
fn rate_hz(signal: &Signal, signals: &[Signal]) -> Option<f64> {
    let is_time = |other: &&Signal| other.role == Some(Quantity::Time) && other.samples == signal.samples;
    let time = signals.iter().find(is_time)?;
    let unit = time.unit.as_deref().unwrap_or("s");
    let duration_s = time.increase? * parse_quantity(&format!("1 {unit}"), "s").unwrap_or(1.0);
    (duration_s > 0.0).then(|| (signal.samples - 1) as f64 / duration_s)
}

/// Returns the command that detects in a file, with the first signal of each role, or a capital word.
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

/// Returns the signals of a file as text.
#[must_use]
pub fn signals_text(file: &str, signals: &[Signal]) -> String {
    let has_labels = signals.iter().any(|signal| signal.label.is_some());
    let heading = ["signal", "role", "shape", "unit", "rate", "range"];
    let mut table = Table::new(heading.into_iter().chain(has_labels.then_some("text"))).flush_left();
    for signal in signals {
        let dash = || "—".to_owned();
        let shape: Vec<String> = signal.shape.iter().map(usize::to_string).collect();
        let range = signal.range.map_or_else(dash, |(low, high)| format!("{} to {}", plain(low), plain(high)));
        let undefined = if signal.undefined == 0 { String::new() } else { format!(", {} undefined", signal.undefined) };
        let cells = [
            signal.name.clone(),
            signal.role.map_or_else(dash, |role| role.name().to_owned()),
            shape.join(" x "),
            signal.unit.clone().unwrap_or_else(dash),
            rate_hz(signal, signals).map_or_else(dash, |rate_hz| format!("{} Hz", significant(rate_hz))),
            format!("{range}{undefined}"),
        ];
        table.row(cells.into_iter().chain(has_labels.then(|| signal.label.clone().unwrap_or_default())));
    }
    let roles = Roles::of(signals);
    let mut notes = String::new();
    for quantity in Quantity::ALL {
        match roles.candidates[quantity as usize].as_slice() {
            [] if quantity != Quantity::Velocity => {
                notes += &format!(
                    "{0}: no name or unit shows it; choose a signal for {1}\n",
                    quantity.name(),
                    quantity.name().to_uppercase()
                );
            }
            [_, others @ ..] if !others.is_empty() => {
                let others: Vec<&str> = others.iter().map(|index| signals[*index].name.as_str()).collect();
                notes += &format!("{}: or {}\n", quantity.name(), others.join(", "));
            }
            _ => {}
        }
    }
    format!(
        "{file}: {}\n\n{table}\n{notes}{}\n",
        trocar_document::counted(signals.len() as u64, "signal"),
        command(file, signals)
    )
}

/// Returns the signals of a file as JSON.
#[must_use]
pub fn signals_object(file: &str, signals: &[Signal]) -> Json {
    let object = |signal: &Signal| {
        json!({
            "name": signal.name,
            "label": signal.label,
            "unit": signal.unit,
            "shape": signal.shape,
            "samples": signal.samples,
            "undefined": signal.undefined,
            "rate_hz": rate_hz(signal, signals),
            "min": signal.range.map(|(low, _)| low),
            "max": signal.range.map(|(_, high)| high),
            "role": signal.role.map(Quantity::name),
            "column": signal.column(),
        })
    };
    json!({
        "trocar_version": env!("CARGO_PKG_VERSION"),
        "file": file,
        "signals": signals.iter().map(object).collect::<Vec<_>>(),
        "roles_are_unique": Roles::of(signals).are_unique(),
        "command": command(file, signals),
    })
}
