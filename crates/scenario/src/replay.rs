use std::sync::{Arc, Mutex, PoisonError};

use trocar_core::settings::{Key, KeySource as _};

use super::builtin;
use super::document::Source;
use super::error::ScenarioError;
use super::value::Value;
use super::values::{Values, replays_force, replays_position};
use trocar_core::detector::DetectorSettings;
use trocar_core::estimation::{ContactSettings, RlsSettings};
use trocar_core::time::{TickGrid, whole_ticks};
use trocar_engine::operator::MotionSettings;
use trocar_engine::sensor::SensorSettings;
use trocar_engine::tissue::TissueSettings;
use trocar_recording::{
    Column, ColumnError, ColumnSettings, Columns, FileSettings, Limits, OffsetSettings, Problem, Quantity, Recording,
    ScaleSettings, SignSettings, Signal, first_where, kept, list_signals, open_recording, read_csv, scan_csv,
};

const FILE: &str = FileSettings::KEYS[0].path;
const TARE: &str = FileSettings::KEYS[2].path;

/// Regardless of recording.max_samples: the maximum ticks of a time grid.
const MAX_EVEN_SAMPLES: u64 = 1_000_000_000;

#[derive(Debug, Clone)]
pub struct RecordingSpec {
    /// In SI units and this crate's signs.
    pub recording: Recording,
    /// In s after the first sample.
    pub ruptures_s: Vec<f64>,
}

#[derive(Debug, Clone)]
pub struct DetectionSpec {
    pub recording: RecordingSpec,
    pub settings: DetectionSettings,
}

#[derive(Debug, Clone)]
pub struct DetectionSettings {
    pub estimator: RlsSettings,
    pub detector: DetectorSettings,
    /// Position of the tissue's surface in m.
    pub contact_m: f64,
    /// In m, for the velocity filter; 0: estimated from the recording.
    pub position_resolution_m: f64,
    /// In the velocity filter, in m/s².
    pub acceleration_std_m_per_s2: f64,
}

impl DetectionSettings {
    /// Fills in derived values.
    pub fn resolve(values: &mut Values) -> Result<Self, ScenarioError> {
        let sensor = SensorSettings::read(values)?;
        let settings = Self {
            estimator: RlsSettings::read(values)?,
            detector: DetectorSettings::read(values)?,
            contact_m: ContactSettings::read(values)?.contact_m,
            position_resolution_m: sensor.position_resolution_m,
            acceleration_std_m_per_s2: sensor.acceleration_std_m_per_s2,
        };
        settings.estimator.validate().map_err(|error| values.out_of_range(&error))?;
        settings.detector.validate().map_err(|error| values.out_of_range(&error))?;
        Ok(settings)
    }
}

impl DetectionSpec {
    pub fn resolve(values: &mut Values) -> Result<Self, ScenarioError> {
        let settings = DetectionSettings::resolve(values)?;
        if !values.is_given(FILE) {
            return Err(no_recording(values));
        }
        let recording = load_recording(values)?;
        Self::new(values, settings, recording)
    }

    /// For samples in memory: uses the labels and limits of the values, not their columns and signs.
    pub fn of(values: &mut Values, recording: Recording) -> Result<Self, ScenarioError> {
        let settings = DetectionSettings::resolve(values)?;
        let recording = labelled(values, recording)?;
        Self::new(values, settings, recording)
    }

    fn new(values: &mut Values, settings: DetectionSettings, recording: RecordingSpec) -> Result<Self, ScenarioError> {
        check_even_samples(values, &recording.recording)?;
        Ok(Self { recording, settings })
    }
}

/// The last tick under load, so a label between two ticks gives the earlier one.
pub(super) fn rupture_ticks(spec: &RecordingSpec, grid: &TickGrid) -> Arc<[u64]> {
    let tick_s = grid.tick_s();
    let tick = |label: &f64| whole_ticks(*label, tick_s).unwrap_or((label / tick_s) as u64);
    let mut ticks: Vec<u64> = spec.ruptures_s.iter().map(tick).collect();
    ticks.dedup();
    ticks.into()
}

pub(super) fn rupture_depths(spec: &RecordingSpec) -> Arc<[f64]> {
    let (time_s, position_m) = (spec.recording.time_s(), spec.recording.position_m());
    let start_s = time_s.first().copied().unwrap_or(0.0);
    let depth = |label: &f64| {
        let after = time_s.partition_point(|time| time - start_s <= *label);
        position_m[after.saturating_sub(1)]
    };
    spec.ruptures_s.iter().map(depth).collect()
}

fn check_ruptures(values: &Values, ruptures_s: &[f64], end_s: f64) -> Result<(), ScenarioError> {
    let refuse = |message: String| Err(values.error("recording.ruptures_s", message));
    if let Some(outside) = ruptures_s.iter().find(|&&t| !(0.0..=end_s).contains(&t)) {
        return refuse(format!(
            "recording.ruptures_s has {outside}, must be within the recording, from 0 to {end_s} s"
        ));
    }
    if let Some(pair) = ruptures_s.windows(2).find(|pair| pair[1] <= pair[0]) {
        return refuse(format!("recording.ruptures_s has {} before {}, must ascend", pair[0], pair[1]));
    }
    Ok(())
}

fn check_magnitudes(values: &Values, recording: &Recording) -> Result<(), ScenarioError> {
    const MAX_MAGNITUDE: f64 = Limits::MAX_MAGNITUDE;
    let quantities = [
        ("recording.scale.position_m", "m", recording.position_m()),
        ("recording.scale.velocity_m_per_s", "m/s", recording.velocity_m_per_s().unwrap_or(&[])),
        ("recording.scale.force_n", "N", recording.force_n()),
    ];
    for (scale, unit, samples) in quantities {
        if let Some(sample) = first_where(samples, |value| value.abs() > MAX_MAGNITUDE) {
            let (value, time_s) = (samples[sample], recording.time_s()[sample]);
            let message = format!("the recording has {value:e} {unit} at {time_s} s, at most {MAX_MAGNITUDE:e} {unit}");
            return Err(values.error(FILE, message).remedy(format!("correct it, or give {scale}")));
        }
    }
    Ok(())
}

/// Limits the number of evenly resampled samples, which fill gaps. Twice the recording's number is always allowed.
fn check_even_samples(values: &mut Values, recording: &Recording) -> Result<(), ScenarioError> {
    let interval_s = recording.median_interval_s();
    // If the times increase, the median interval is a tick.
    let samples = recording.ticks_covered(interval_s).unwrap_or(0) as u64;
    let max_samples = (Limits::read(values)?.max_samples as u64).min(MAX_EVEN_SAMPLES);
    if samples <= max_samples.max(2 * recording.len() as u64) {
        return Ok(());
    }
    let (_, gap_s) = recording.interval_range_s();
    let key = ["recording.max_gap_s", "recording.max_samples"].into_iter().find(|key| values.place(key).is_some());
    let message = format!(
        "evenly spaced, the recording would have {:.3e} samples, at most {max_samples} (recording.max_samples): \
         its longest gap, {gap_s} s, would be filled with samples {interval_s:.3e} s apart",
        samples as f64
    );
    Err(values.error(key.unwrap_or(FILE), message).remedy("cut the recording at the gap"))
}

pub(super) fn limiting_key(problem: &Problem) -> Option<&'static str> {
    match problem {
        Problem::TooLarge { .. } | Problem::TooManyBytes { .. } => Some("recording.max_bytes"),
        Problem::TooManySamples { .. } => Some("recording.max_samples"),
        Problem::Gap { .. } => Some("recording.max_gap_s"),
        _ => None,
    }
}

pub(super) fn embedded(values: &Values, key: &str, name: &str) -> Result<&'static [u8], ScenarioError> {
    builtin::content(name).ok_or_else(|| {
        let known: Vec<_> = builtin::recordings().collect();
        let message = format!("there is no recording {}", Source::Builtin(name.to_owned()).display());
        values.error(key, message).remedy(format!("the shipped recordings are {}", known.join(", ")))
    })
}

/// Reads the columns with scales and signs.
pub fn recording_columns(values: &mut Values) -> Result<Columns, ScenarioError> {
    let (names, scales) = (ColumnSettings::read(values)?, ScaleSettings::read(values)?);
    let (signs, offsets) = (SignSettings::read(values)?, OffsetSettings::read(values)?);
    let column = |key: usize, name: &str, scale: f64, offset: f64| {
        let refuse = |error: ColumnError| values.error(ColumnSettings::KEYS[key].path, error.to_string());
        Column::new(name, scale).and_then(|column| column.with_offset(offset)).map_err(refuse)
    };
    let velocity =
        |name: String| column(2, &name, scales.velocity_m_per_s * signs.velocity_sign, offsets.velocity_m_per_s);
    Ok(Columns {
        time: column(0, &names.time_s, scales.time_s, offsets.time_s)?,
        position: column(1, &names.position_m, scales.position_m * signs.position_sign, offsets.position_m)?,
        velocity: names.velocity_m_per_s.map(velocity).transpose()?,
        force: column(3, &names.force_n, scales.force_n * signs.force_sign, offsets.force_n)?,
    })
}

pub fn recording_signals(values: &mut Values) -> Result<Vec<Signal>, ScenarioError> {
    let Some(source) = values.file(FILE) else {
        return Err(no_recording(values));
    };
    let limits = Limits::read(values)?;
    let source = source.canonical();
    let listed = match source.plain() {
        Source::Disk(path) => list_signals(path, &limits),
        Source::Builtin(name) => scan_csv(&source.display(), embedded(values, FILE, name)?, &limits),
        Source::Text { name, text } => scan_csv(name, text.as_bytes(), &limits),
        Source::Memory(_) | Source::Kept(..) => {
            let name = source.display();
            return Err(values.error(FILE, format!("{name} is a recording in memory: it has no signals to list")));
        }
    };
    listed.map_err(|error| ScenarioError::new(error.to_string()).at(values.place(FILE)))
}

fn no_recording(values: &Values) -> ScenarioError {
    values.error(FILE, "recording.file is missing").remedy("give the path of a CSV file as recording.file")
}

pub(super) fn missing_recording(values: &Values) -> ScenarioError {
    let kinds = [
        (MotionSettings::KEY.path, replays_position(values), "minimum-jerk"),
        (TissueSettings::KEY.path, replays_force(values), "layers"),
    ];
    let replaying: Vec<&str> = kinds.iter().filter(|(_, replays, _)| *replays).map(|(key, ..)| *key).collect();
    let default = |key: &str| if values.place(key).is_none() { " (the default)" } else { "" };
    let stated: Vec<_> = replaying
        .iter()
        .map(|key| format!("{key} is {:?}{}", values.word(key).unwrap_or_default(), default(key)))
        .collect();
    let other = |(key, _, word): &(&str, bool, &str)| format!("another {key}, e.g. \"{word}\"");
    let others: Vec<_> = kinds.iter().filter(|(_, replays, _)| *replays).map(other).collect();
    let Some(key) = replaying.first() else {
        return no_recording(values);
    };
    values
        .error(key, format!("{}, but recording.file is missing", stated.join(" and ")))
        .remedy(format!("give recording.file, or {}", others.join(" and ")))
}

fn in_memory(values: &Values, name: &str, limits: &Limits) -> Result<Recording, ScenarioError> {
    let Some(recording) = kept(name) else {
        let error = values.error(FILE, format!("there is no recording {name} in memory"));
        return Err(error.remedy("give its samples again, or the path of a file"));
    };
    recording.check_gaps(limits.max_gap_s).map_err(|error| values.error(FILE, error.to_string()))?;
    Ok(Recording::clone(&recording))
}

/// Keeps the last shipped recording, because a comparison loads several scenarios that replay it.
fn last_shipped<E>(
    name: &str,
    columns: &Columns,
    limits: &Limits,
    read: impl FnOnce() -> Result<Recording, E>,
) -> Result<Recording, E> {
    static LAST: Mutex<Option<(String, Columns, Limits, Recording)>> = Mutex::new(None);
    let locked = || LAST.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some((of, with, within, recording)) = &*locked()
        && of == name
        && with == columns
        && within == limits
    {
        return Ok(recording.clone());
    }
    let recording = read()?;
    *locked() = Some((name.to_owned(), columns.clone(), limits.clone(), recording.clone()));
    Ok(recording)
}

pub(super) fn load_recording(values: &mut Values) -> Result<RecordingSpec, ScenarioError> {
    let Some(source) = values.file(FILE) else {
        return Err(missing_recording(values));
    };
    let columns = recording_columns(values)?;
    let limits = Limits::read(values)?;
    let source = source.canonical();
    let open = |path: &_| open_recording(path, &columns, &limits);
    let read = match source.plain() {
        Source::Disk(path) => match source.kept() {
            Some(files) => files.recording((path, &columns, &limits), || open(path)),
            None => open(path),
        },
        Source::Builtin(name) => {
            let content = embedded(values, FILE, name)?;
            let path = source.display();
            last_shipped(&path, &columns, &limits, || read_csv(&path, content, &columns, &limits))
        }
        Source::Text { name, text } => read_csv(name, text.as_bytes(), &columns, &limits),
        Source::Memory(_) | Source::Kept(..) => Ok(in_memory(values, &source.display(), &limits)?),
    };
    let recording = read.map_err(|error| {
        // Report a missing column at its key.
        let column = error.place.column.as_deref();
        let named = |key: &&Key| column.is_some() && values.optional_word(key.path) == column;
        let column = ColumnSettings::KEYS.iter().find(named).and_then(|key| values.place(key.path));
        let place = limiting_key(&error.problem).and_then(|key| values.place(key)).or(column);
        let missing = match &error.problem {
            Problem::MissingColumn { quantity, .. } | Problem::MissingSignal { quantity, .. } => *quantity,
            _ => None,
        };
        let error = ScenarioError::new(error.to_string()).at(place.or(values.place(FILE)));
        // The column may be named in a base.
        let remedy = "name the file's column, or set recording.columns.velocity_m_per_s = \"\" to estimate the velocity from the position";
        match missing {
            Some(Quantity::Velocity) => error.remedy(remedy),
            Some(Quantity::Position) => error.remedy(
                "name the column of the position; if none was recorded and the needle moves steadily, give the time times its speed \
                 in m/s, as in --position time:0.005",
            ),
            Some(Quantity::Time | Quantity::Force) | None => error,
        }
    })?;
    let spec = labelled(values, recording)?;
    values.derive_keeping_place(FILE, Value::Text(source.display()));
    Ok(spec)
}

fn labelled(values: &mut Values, recording: Recording) -> Result<RecordingSpec, ScenarioError> {
    check_magnitudes(values, &recording)?;
    let FileSettings { ruptures_s, tare_s, zero_at_start, .. } = FileSettings::read(values)?;
    check_ruptures(values, &ruptures_s, recording.duration_s())?;
    let duration_s = recording.duration_s();
    if tare_s >= duration_s {
        let message = format!("{TARE} is {tare_s} s, must be below the length of the recording, {duration_s} s");
        return Err(values.error(TARE, message).remedy("give the time before the needle touches the tissue, in s"));
    }
    Ok(RecordingSpec { recording: recording.tared(tare_s).zeroed(zero_at_start), ruptures_s })
}
