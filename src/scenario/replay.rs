//! The recording that a scenario replays, or that a detection reads.

use std::sync::Arc;

use super::builtin;
use super::document::Source;
use super::error::ScenarioError;
use super::settings::{detector, estimator};
use super::value::Value;
use super::values::Values;
use crate::detection::DetectorSettings;
use crate::estimation::RlsSettings;
use crate::recording::{Column, Columns, Limits, Recording, open_csv, read_csv};
use crate::time::{TickGrid, nearest_ticks};

/// A recording with its labels, as a scenario describes it.
#[derive(Debug, Clone)]
pub struct RecordingSpec {
    /// The samples, in SI units and this crate's signs.
    pub recording: Recording,
    /// When layers rupture, in s after the first sample.
    pub ruptures_s: Vec<f64>,
}

/// What detecting ruptures in a recording needs.
#[derive(Debug, Clone)]
pub struct DetectionSpec {
    /// The recording and its labels.
    pub recording: RecordingSpec,
    /// The estimator.
    pub estimator: RlsSettings,
    /// The detector.
    pub detector: DetectorSettings,
    /// Where the tissue begins, in m.
    pub contact_m: f64,
    /// Step of the recorded positions in m, for the velocity filter; 0: taken from the recording.
    pub position_resolution_m: f64,
    /// Acceleration that the velocity filter expects, in m/s².
    pub acceleration_std_m_per_s2: f64,
}

impl DetectionSpec {
    /// Resolves the values that detection needs; derived ones are filled in.
    ///
    /// # Errors
    /// As [`Scenario::load`](super::Scenario::load).
    pub fn resolve(values: &mut Values) -> Result<Self, ScenarioError> {
        let spec = Self {
            estimator: estimator(values)?,
            detector: detector(values)?,
            contact_m: values.number("estimator.contact_m")?,
            position_resolution_m: values.number("sensor.position_resolution_m")?,
            acceleration_std_m_per_s2: values.number("sensor.acceleration_std_m_per_s2")?,
            recording: load_recording(values)?,
        };
        spec.estimator.validate().map_err(|error| values.out_of_range(&error))?;
        spec.detector.validate().map_err(|error| values.out_of_range(&error))?;
        Ok(spec)
    }
}

/// The ticks of the labelled ruptures.
pub(super) fn rupture_ticks(
    values: &Values,
    spec: &RecordingSpec,
    grid: &TickGrid,
) -> Result<Arc<[u64]>, ScenarioError> {
    let end_s = spec.recording.duration_s();
    let refuse = |message: String| values.error("recording.ruptures_s", message);
    if let Some(outside) = spec.ruptures_s.iter().find(|&&t| !(0.0..=end_s).contains(&t)) {
        let message = format!("recording.ruptures_s has {outside}, must be within the recording, from 0 to {end_s} s");
        return Err(refuse(message));
    }
    if let Some(pair) = spec.ruptures_s.windows(2).find(|pair| pair[1] <= pair[0]) {
        return Err(refuse(format!("recording.ruptures_s has {} before {}, must ascend", pair[0], pair[1])));
    }
    let mut ticks: Vec<u64> = spec.ruptures_s.iter().map(|t| nearest_ticks(*t, grid.tick_s())).collect();
    ticks.dedup();
    Ok(ticks.into())
}

/// Reads the recording that values describe.
pub(super) fn load_recording(values: &mut Values) -> Result<RecordingSpec, ScenarioError> {
    let Some(source) = values.file("recording.file") else {
        return Err(values
            .error("recording.file", "recording.file is missing, and operator or tissue replay a recording")
            .remedy("give recording.file, or other kinds of operator and tissue"));
    };
    let column = |quantity: &str, sign: f64| {
        let scale = values.number(&format!("recording.scale.{quantity}"))? * sign;
        let path = format!("recording.columns.{quantity}");
        Column::new(values.text(&path)?, scale).map_err(|error| values.error(&path, error.to_string()))
    };
    let position_sign = values.number("recording.position_sign")?;
    let velocity = values.is_given("recording.columns.velocity_m_per_s");
    let columns = Columns {
        time: column("time_s", 1.0)?,
        position: column("position_m", position_sign)?,
        velocity: velocity.then(|| column("velocity_m_per_s", position_sign)).transpose()?,
        force: column("force_n", values.number("recording.force_sign")?)?,
    };
    let limits = Limits {
        max_bytes: values.whole("recording.max_bytes")?,
        max_samples: usize::try_from(values.whole("recording.max_samples")?).unwrap_or(usize::MAX),
        max_gap_s: values.optional_number("recording.max_gap_s"),
    };
    let source = source.canonical();
    let read = match &source {
        Source::Disk(path) => open_csv(path, &columns, &limits),
        Source::Builtin(name) => match builtin::content(name) {
            Some(content) => read_csv(&source.display(), content, &columns, &limits),
            None => {
                let known: Vec<_> = builtin::names().filter(|name| name.ends_with(".csv")).collect();
                let message = format!("there is no recording {}", source.display());
                return Err(values.error("recording.file", message).remedy(format!("there are {}", known.join(", "))));
            }
        },
    };
    let recording = read.map_err(|error| values.error("recording.file", error.to_string()))?;
    let ruptures_s = values.numbers("recording.ruptures_s")?.to_vec();
    values.derive_keeping_place("recording.file", Value::Text(source.display()));
    Ok(RecordingSpec { recording, ruptures_s })
}
