//! A recording on the command line: a file with flags for its columns, or a scenario with a recording.

use clap::Args;

use super::ScenarioArgs;
use super::error::Failure;
use super::quantity::{column, quantity};
use trocar_base::warning::{Code, Warning};
use trocar_recording::{Column, Limits, Quantity, Roles, Signal, list_signals, signal_names, signals_by_name};
use trocar_scenario::{Reader, ScenarioError, Source, Values, keys_without_effect, parse_column};

/// The columns of a recording, and the parts of a file that are not its signals.
#[derive(Debug, Default, Args)]
pub(super) struct ColumnArgs {
    /// Column with the time (its name as `trocar detect --list` shows it, or its number); the factor or unit (s, ms,
    /// us, ns, min) converts it to s, as in t:1e-3 or t:ms; dates need none [default: time_s]
    #[arg(long, value_name = "COLUMN[:FACTOR|:UNIT]", value_parser = column("s"))]
    time: Option<Column>,
    /// Samples per second of recordings without a time
    #[arg(long = "rate", value_name = "HZ", conflicts_with = "time", value_parser = quantity("Hz"), allow_hyphen_values = true)]
    rate_hz: Option<f64>,
    /// Lines of text before the table; a preamble is usually found without this flag
    #[arg(long, value_name = "N")]
    skip_lines: Option<u64>,
    /// Column with the position of the needle; the factor or unit (m, cm, mm, um) converts it to m, and an offset can
    /// follow, as in z:-1+0.1 or z:-mm+100mm [default: position_m]
    #[arg(long, value_name = "COLUMN[:FACTOR|:UNIT]", allow_hyphen_values = true, value_parser = column("m"))]
    position: Option<Column>,
    /// Column with the velocity of the needle; the factor or unit (m/s, cm/s, mm/s, um/s) converts it to m/s
    /// [default: estimated from the position]
    #[arg(long, value_name = "COLUMN[:FACTOR|:UNIT]", allow_hyphen_values = true, value_parser = column("m/s"))]
    velocity: Option<Column>,
    /// Subtract the first position from all positions, so that the motion starts at 0
    #[arg(long)]
    zero_at_start: bool,
    /// Subtract the mean force of the first S seconds, in which the needle must be free [default: 0, no tare]
    #[arg(long, value_name = "S", value_parser = quantity("s"), allow_hyphen_values = true)]
    tare_s: Option<f64>,
    /// Column with the force on the needle; the factor or unit (N, kN, cN, mN, gf, kgf) converts it to N [default:
    /// force_n]
    #[arg(long, value_name = "COLUMN[:FACTOR|:UNIT]", allow_hyphen_values = true, value_parser = column("N"))]
    force: Option<Column>,
}

pub(super) struct RecordedFlags<'a> {
    pub(super) columns: &'a ColumnArgs,
    pub(super) contact_m: Option<f64>,
    pub(super) ruptures_s: &'a [f64],
    pub(super) changes: &'a ScenarioArgs,
}

impl RecordedFlags<'_> {
    pub(super) fn check_ruptures(&self, recordings: usize) -> Result<(), Failure> {
        if self.ruptures_s.is_empty() || recordings <= 1 {
            return Ok(());
        }
        Err(Failure::input(format!(
            "--rupture-s labels a single recording, but there are {recordings}; use --labels FILE"
        )))
    }

    pub(super) fn unread(&self, values: &Values, reader: Reader) -> Vec<Warning> {
        keys_without_effect(values, &self.changes.settings, reader)
    }

    /// With the path of the recording if given. Flags override `tuning`, and `--set` overrides both.
    pub(super) fn settings(&self, recording: Option<&str>, tuning: &[String]) -> Vec<String> {
        let mut settings: Vec<String> = recording.and_then(file_setting).into_iter().collect();
        settings.extend(tuning.iter().cloned());
        settings.extend(self.columns.settings());
        if let Some(contact_m) = self.contact_m {
            settings.push(format!("estimator.contact_m={contact_m:?}"));
        }
        if !self.ruptures_s.is_empty() {
            settings.push(format!("recording.ruptures_s={:?}", self.ruptures_s));
        }
        settings.extend(self.changes.settings.iter().cloned());
        settings
    }
}

impl ColumnArgs {
    /// The flags that have no meaning for a live stream, and true if they are given.
    pub(super) fn of_files(&self) -> [(&'static str, bool); 3] {
        [
            ("--rate", self.rate_hz.is_some()),
            ("--skip-lines", self.skip_lines.is_some()),
            ("--zero-at-start", self.zero_at_start),
        ]
    }

    pub(super) fn flags(&self) -> Vec<String> {
        let given = [
            ("--time", &self.time),
            ("--position", &self.position),
            ("--velocity", &self.velocity),
            ("--force", &self.force),
        ];
        let words = |(flag, column): (&str, &Option<Column>)| {
            let column = column.as_ref()?;
            let (scale, offset) = (column.scale(), column.offset());
            let factor = match (scale == 1.0, offset == 0.0) {
                (true, true) => String::new(),
                (false, true) => format!(":{scale:?}"),
                (_, false) => format!(":{scale:?}{offset:+?}"),
            };
            Some([flag.to_owned(), format!("{}{factor}", column.name())])
        };
        let number =
            |flag: &str, value: Option<String>| value.into_iter().flat_map(|value| [flag.to_owned(), value]).collect();
        let others: [Vec<String>; 4] = [
            number("--rate", self.rate_hz.map(|rate_hz| format!("{rate_hz:?}"))),
            number("--skip-lines", self.skip_lines.map(|lines| lines.to_string())),
            self.zero_at_start.then(|| "--zero-at-start".to_owned()).into_iter().collect(),
            number("--tare-s", self.tare_s.map(|tare_s| format!("{tare_s:?}"))),
        ];
        given.into_iter().filter_map(words).flatten().chain(others.into_iter().flatten()).collect()
    }

    fn settings(&self) -> Vec<String> {
        let mut settings = vec![];
        let columns = [
            ("time_s", &self.time, None),
            ("position_m", &self.position, Some("position_sign")),
            ("velocity_m_per_s", &self.velocity, Some("velocity_sign")),
            ("force_n", &self.force, Some("force_sign")),
        ];
        for (quantity, column, sign) in columns {
            let Some(column) = column else { continue };
            settings.push(format!("recording.columns.{quantity}={}", quoted(column.name())));
            let scale = if sign.is_some() { column.scale().abs() } else { column.scale() };
            settings.push(format!("recording.scale.{quantity}={scale:?}"));
            if column.offset() != 0.0 {
                settings.push(format!("recording.offset.{quantity}={:?}", column.offset()));
            }
            if let Some(sign) = sign {
                settings.push(format!("recording.{sign}={}", column.scale().signum()));
            }
        }
        settings.extend(self.rate_hz.map(|rate_hz| format!("recording.rate_hz={rate_hz:?}")));
        settings.extend(self.skip_lines.map(|lines| format!("recording.skip_lines={lines}")));
        settings.extend(self.zero_at_start.then(|| "recording.zero_at_start=true".to_owned()));
        settings.extend(self.tare_s.map(|tare_s| format!("recording.tare_s={tare_s:?}")));
        settings
    }
}

pub(super) fn is_scenario(given: &str) -> bool {
    Source::parse(given).display().ends_with(".toml")
}

/// `None` for a scenario, which names its recording.
pub(super) fn file_setting(given: &str) -> Option<String> {
    (!is_scenario(given)).then(|| format!("recording.file={}", quoted(given)))
}

pub(super) fn load(given: &str, settings: &[String]) -> Result<Values, ScenarioError> {
    let source = Source::parse(given);
    if is_scenario(given) {
        Values::load(&source, settings)
    } else {
        Values::from_settings(&source.stem(), settings).map_err(of_flags)
    }
}

/// Loads like [`load`], and guesses the columns from the names and units of the signals. It guesses only if no flag
/// or key sets the columns, the file lacks a default column and the guess is unique; then it returns a warning.
pub(super) fn load_guessed(
    given: &str,
    flags: &RecordedFlags<'_>,
    tuning: &[String],
) -> Result<(Values, Option<Warning>), ScenarioError> {
    let settings = flags.settings(Some(given), tuning);
    let values = load(given, &settings)?;
    let Some((columns, warning)) = guess(given, &values) else { return Ok((values, None)) };
    // --set may also name a column.
    let guessed: Vec<String> = columns.settings().into_iter().chain(settings).collect();
    Ok((load(given, &guessed)?, Some(warning)))
}

fn guess(given: &str, values: &Values) -> Option<(ColumnArgs, Warning)> {
    let path = std::path::Path::new(given);
    let sections = ["recording.columns", "recording.scale", "recording.offset"];
    let signs = ["recording.force_sign", "recording.position_sign", "recording.velocity_sign"];
    let is_given = sections.iter().any(|section| values.section_place(section).is_some())
        || signs.iter().any(|key| values.place(key).is_some());
    if is_scenario(given) || is_given || !path.is_file() {
        return None;
    }
    let limits = Limits::read(&mut values.clone()).ok()?;
    let names = signal_names(path, &limits).ok()?;
    let default = |quantity: Quantity| {
        let wanted = ["time_s", "position_m", "velocity_m_per_s", "force_n"][quantity as usize];
        names.iter().find(|name| name.trim_start_matches('/') == wanted)
    };
    let needed = |quantity: &Quantity| match quantity {
        Quantity::Time => limits.rate_hz.is_none(),
        Quantity::Velocity => false,
        Quantity::Position | Quantity::Force => true,
    };
    if Quantity::ALL.into_iter().filter(needed).all(|quantity| default(quantity).is_some()) {
        return None;
    }
    // A quantity without a unique candidate keeps its default name; reading the file then reports it.
    let choose = |signals: &[Signal]| -> Vec<(Quantity, String)> {
        let roles = Roles::of(signals);
        let of = |quantity: Quantity| match (default(quantity), roles.candidates[quantity as usize].as_slice()) {
            (Some(name), _) => Some((quantity, name.clone())),
            (None, [index]) => Some((quantity, signals[*index].column())),
            (None, [] | [_, _, ..]) => None,
        };
        Quantity::ALL
            .into_iter()
            .filter(|quantity| *quantity != Quantity::Time || needed(quantity))
            .filter_map(of)
            .collect()
    };
    let is_complete = |chosen: &[(Quantity, String)]| {
        let has = |quantity: Quantity| chosen.iter().any(|(of, _)| *of == quantity);
        Quantity::ALL.into_iter().filter(needed).all(has)
    };
    let listed = list_signals(path, &limits).ok().map(|signals| choose(&signals));
    // If a sample is invalid, use the names alone, so that reading the file reports the invalid sample.
    let by_name = choose(&signals_by_name(&names));
    let chosen = match listed {
        Some(listed) if is_complete(&listed) || !is_complete(&by_name) => listed,
        _ => by_name,
    };
    let column = |quantity: Quantity| {
        let (_, text) = chosen.iter().find(|(of, _)| *of == quantity)?;
        parse_column(text, quantity.unit()).ok()
    };
    let [time, position, velocity, force] = Quantity::ALL.map(column);
    let columns = ColumnArgs { time, position, velocity, force, ..ColumnArgs::default() };
    let flags: Vec<String> = chosen.iter().map(|(quantity, text)| format!("--{} {text}", quantity.name())).collect();
    let message = format!("the columns are guessed: {}", flags.join(" "));
    let remedy = format!("give these flags, or others: `trocar detect {given} --list` shows all signals");
    Some((columns, Warning::new(Code::GuessedColumns, message).at("--time, --position, --force").remedy(remedy)))
}

/// Removes the place of an error: without a scenario file, it is a flag, which the message names.
pub(super) fn of_flags(mut error: ScenarioError) -> ScenarioError {
    error.place = None;
    error
}

pub(super) fn placed(given: &str) -> impl Fn(ScenarioError) -> ScenarioError {
    let is_scenario = is_scenario(given);
    move |error| if is_scenario { error } else { of_flags(error) }
}

fn quoted(text: &str) -> String {
    toml::Value::String(text.to_owned()).to_string()
}
