use std::path::Path;

use trocar_base::warning::Warning;
use trocar_recording::{Column, Columns, Limits, Recording, open_recording};

use crate::IdentifyError;

pub(crate) const MIN_SAMPLES: usize = 200;
pub(crate) const MIN_DURATION_S: f64 = 0.2;

const HUGE: f64 = 1e9;

/// In SI units, evenly spaced.
pub(crate) struct Grid {
    pub(crate) name: String,
    pub(crate) interval_s: f64,
    pub(crate) position_m: Vec<f64>,
    pub(crate) force_n: Vec<f64>,
    pub(crate) others: Vec<Vec<f64>>,
    pub(crate) unfinished: Option<Warning>,
}

impl Grid {
    /// Resamples unevenly spaced samples at their median interval.
    pub(crate) fn open<'a>(
        path: &Path,
        time: &Column,
        position: &Column,
        force: &Column,
        mut others: impl Iterator<Item = &'a Column>,
        limits: &Limits,
    ) -> Result<Self, IdentifyError> {
        // The reader accepts one further column in any unit, as its velocity.
        let of = |further: Option<&Column>| {
            let [time, position, force] = [time, position, force].map(Clone::clone);
            open_recording(path, &Columns { time, position, velocity: further.cloned(), force }, limits)
        };
        let recording = of(others.next())?;
        let name = path.display().to_string();
        let interval_s = recording.median_interval_s();
        let (low_s, high_s) = recording.interval_range_s();
        let is_even = high_s - low_s <= 1e-3 * interval_s;
        let resample = |recording: &Recording, values: &[f64]| -> Result<Vec<f64>, IdentifyError> {
            if is_even {
                return Ok(values.to_vec());
            }
            let refuse = |source| IdentifyError::Resample { recording: name.clone(), source };
            let ticks = recording.ticks_covered(interval_s).map_err(refuse)?.min(limits.max_samples);
            recording.resample_values(values, interval_s, ticks).map_err(refuse)
        };
        let further =
            |recording: &Recording| recording.velocity_m_per_s().map(|values| resample(recording, values)).transpose();
        let mut rows: Vec<Vec<f64>> = further(&recording)?.into_iter().collect();
        for other in others {
            rows.extend(further(&of(Some(other))?)?);
        }
        let position_m = resample(&recording, recording.position_m())?;
        let force_n = resample(&recording, recording.force_n())?;
        Ok(Self { name, interval_s, position_m, force_n, others: rows, unfinished: recording.unfinished_warning() })
    }
}

/// The first column has the expected length.
pub(crate) fn check(name: &str, interval_s: f64, columns: &[(&'static str, &[f64])]) -> Result<(), IdentifyError> {
    let recording = || name.to_owned();
    let samples = columns.first().map_or(0, |(_, values)| values.len());
    for (column, values) in columns {
        if values.len() != samples {
            let (given, expected) = (values.len(), samples);
            return Err(IdentifyError::Length { recording: recording(), column, given, expected });
        }
        if let Some(sample) = values.iter().position(|value| value.is_nan() || value.abs() >= HUGE) {
            return Err(IdentifyError::Huge { recording: recording(), column, value: values[sample], sample });
        }
    }
    let duration_s = interval_s * samples.saturating_sub(1) as f64;
    if samples < MIN_SAMPLES || duration_s.is_nan() || duration_s < MIN_DURATION_S {
        return Err(IdentifyError::Short { recording: recording(), samples, duration_s });
    }
    Ok(())
}
