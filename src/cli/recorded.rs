//! A recording as the command line gives it: a file with flags that say what is in it, or the one that a scenario names.

use clap::Args;

use super::ScenarioArgs;
use trocar_sim::recording::Column;
use trocar_sim::scenario::{ScenarioError, Source, Values};

/// Which columns hold what.
#[derive(Debug, Args)]
pub(super) struct ColumnArgs {
    /// Column with the time in s [default: time_s]
    #[arg(long, value_name = "COLUMN[:FACTOR]")]
    time: Option<Column>,
    /// Column with the needle's position in m [default: position_m]
    #[arg(long, value_name = "COLUMN[:FACTOR]", allow_hyphen_values = true)]
    position: Option<Column>,
    /// Column with its velocity in m/s; estimated from the position when not given
    #[arg(long, value_name = "COLUMN[:FACTOR]", allow_hyphen_values = true)]
    velocity: Option<Column>,
    /// Column with the force on it in N [default: force_n]
    #[arg(long, value_name = "COLUMN[:FACTOR]", allow_hyphen_values = true)]
    force: Option<Column>,
}

/// What the flags of a command say of its recordings.
pub(super) struct RecordedFlags<'a> {
    pub(super) columns: &'a ColumnArgs,
    pub(super) contact_m: Option<f64>,
    pub(super) ruptures_s: &'a [f64],
    pub(super) changes: &'a ScenarioArgs,
}

impl RecordedFlags<'_> {
    /// The flags as settings for a recording, or for none, over those of `tuning`; those of --set come last and count.
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
    /// The flags as they were given.
    pub(super) fn flags(&self) -> Vec<String> {
        let given = [
            ("--time", &self.time),
            ("--position", &self.position),
            ("--velocity", &self.velocity),
            ("--force", &self.force),
        ];
        let words = |(flag, column): (&str, &Option<Column>)| {
            let column = column.as_ref()?;
            let scale = if column.scale() == 1.0 { String::new() } else { format!(":{:?}", column.scale()) };
            Some([flag.to_owned(), format!("{}{scale}", column.name())])
        };
        given.into_iter().filter_map(words).flatten().collect()
    }

    /// The flags as settings.
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
            if let Some(sign) = sign {
                settings.push(format!("recording.{sign}={}", column.scale().signum()));
            }
        }
        settings
    }
}

/// Whether a scenario file is meant, and not a recording.
pub(super) fn is_scenario(given: &str) -> bool {
    given.ends_with(".toml")
}

/// The setting that names a recording; none for a scenario, which names its own.
pub(super) fn file_setting(given: &str) -> Option<String> {
    (!is_scenario(given)).then(|| format!("recording.file={}", quoted(given)))
}

/// The values of a scenario file, or those of the settings alone, which then name the recording.
pub(super) fn load(given: &str, settings: &[String]) -> Result<Values, ScenarioError> {
    let source = Source::parse(given);
    if is_scenario(given) {
        Values::load(&source, settings)
    } else {
        Values::from_settings(&source.stem(), settings).map_err(of_flags)
    }
}

/// Without a scenario file, the place of an error is a flag, which the message names better than a made-up line.
pub(super) fn of_flags(mut error: ScenarioError) -> ScenarioError {
    error.place = None;
    error
}

/// The same error, with its place if it stands in the scenario file that was given.
pub(super) fn placed(given: &str) -> impl Fn(ScenarioError) -> ScenarioError {
    let is_scenario = is_scenario(given);
    move |error| if is_scenario { error } else { of_flags(error) }
}

fn quoted(text: &str) -> String {
    toml::Value::String(text.to_owned()).to_string()
}
