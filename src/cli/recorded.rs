//! A recording on the command line: a file with flags for its columns, or a scenario with a recording.

use clap::Args;

use super::quantity::column;
use super::{ScenarioArgs, source_of};
use trocar_sim::recording::Column;
use trocar_sim::scenario::{ScenarioError, Source, Values};

/// The columns of a recording.
#[derive(Debug, Args)]
pub(super) struct ColumnArgs {
    /// Column with the time; converted to s by the factor or unit (s, ms, us, min), as in t:1e-3 or t:ms [default: time_s]
    #[arg(long, value_name = "COLUMN[:FACTOR|:UNIT]", value_parser = column("s"))]
    time: Option<Column>,
    /// Column with the position of the needle; converted to m by the factor or unit (m, cm, mm, um) [default: position_m]
    #[arg(long, value_name = "COLUMN[:FACTOR|:UNIT]", allow_hyphen_values = true, value_parser = column("m"))]
    position: Option<Column>,
    /// Column with the velocity of the needle; converted to m/s by the factor or unit (m/s, cm/s, mm/s, um/s) [default: estimated from
    /// the position]
    #[arg(long, value_name = "COLUMN[:FACTOR|:UNIT]", allow_hyphen_values = true, value_parser = column("m/s"))]
    velocity: Option<Column>,
    /// Column with the force on the needle; converted to N by the factor or unit (N, kN, cN, mN, gf, kgf) [default: force_n]
    #[arg(long, value_name = "COLUMN[:FACTOR|:UNIT]", allow_hyphen_values = true, value_parser = column("N"))]
    force: Option<Column>,
}

/// The flags of a command about its recordings.
pub(super) struct RecordedFlags<'a> {
    pub(super) columns: &'a ColumnArgs,
    pub(super) contact_m: Option<f64>,
    pub(super) ruptures_s: &'a [f64],
    pub(super) changes: &'a ScenarioArgs,
}

impl RecordedFlags<'_> {
    /// Returns the flags as settings, for a recording if one is given. They override those of `tuning`; those of --set come last and have
    /// priority.
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
    /// Returns the flags as given.
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

    /// Returns the flags as settings.
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

/// Returns whether an argument names a scenario, and not a recording.
pub(super) fn is_scenario(given: &str) -> bool {
    Source::parse(given).display().ends_with(".toml")
}

/// Returns the setting with the path of a recording, or `None` for a scenario, which names its own recording.
pub(super) fn file_setting(given: &str) -> Option<String> {
    (!is_scenario(given)).then(|| format!("recording.file={}", quoted(given)))
}

/// Returns the values of a scenario file, or for a recording the values of the settings, which name the recording.
pub(super) fn load(given: &str, settings: &[String]) -> Result<Values, ScenarioError> {
    let source = source_of(given);
    if is_scenario(given) {
        Values::load(&source, settings)
    } else {
        Values::from_settings(&source.stem(), settings).map_err(of_flags)
    }
}

/// Returns the error without its place. Without a scenario file, the place of an error is a flag, which the message names.
pub(super) fn of_flags(mut error: ScenarioError) -> ScenarioError {
    error.place = None;
    error
}

/// Returns a function that keeps the place of an error for a scenario file, and removes it otherwise.
pub(super) fn placed(given: &str) -> impl Fn(ScenarioError) -> ScenarioError {
    let is_scenario = is_scenario(given);
    move |error| if is_scenario { error } else { of_flags(error) }
}

fn quoted(text: &str) -> String {
    toml::Value::String(text.to_owned()).to_string()
}
