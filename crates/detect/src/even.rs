use trocar_base::warning::{Code, Warning};
use trocar_recording::{IgnoredUnit, Joined, Recording, ResampleError};

/// Maximum relative deviation from the median interval.
pub(super) const EVEN_SHARE: f64 = 0.01;

/// Fewer consecutive short intervals are jitter.
const DENSE_INTERVALS: usize = 8;

/// Maximum ratio to the median interval.
const DENSE_SHARE: f64 = 0.5;

/// Ratio to the median rate. Beyond it most samples are interpolated, and their noise is too small.
const MAX_FACTOR: f64 = 10.0;

const MAX_SAMPLES: f64 = 5e6;

pub(super) struct Samples {
    pub(super) interval_s: f64,
    pub(super) time_s: Vec<f64>,
    pub(super) position_m: Vec<f64>,
    pub(super) velocity_m_per_s: Option<Vec<f64>>,
    pub(super) force_n: Vec<f64>,
    pub(super) is_resampled: bool,
    pub(super) notes: Vec<String>,
    /// About units that the columns ignore.
    pub(super) warnings: Vec<Warning>,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Rate {
    Median(f64),
    /// The median interval would lose samples.
    Dense(f64),
    /// Limits the number of samples.
    Limited(f64),
}

impl Rate {
    fn of(recording: &Recording) -> Self {
        let median_s = recording.median_interval_s();
        let intervals: Vec<f64> = recording.time_s().windows(2).map(|pair| pair[1] - pair[0]).collect();
        let longest = |window: &[f64]| window.iter().copied().fold(0.0, f64::max);
        let dense_s = intervals.windows(DENSE_INTERVALS).map(longest).fold(f64::INFINITY, f64::min);
        let is_short = |interval_s: &f64| *interval_s <= DENSE_SHARE * median_s;
        let stretch_s = intervals.split(|interval_s| !is_short(interval_s)).map(|stretch| stretch.iter().sum::<f64>());
        let stretch_s = stretch_s.fold(0.0, f64::max);
        let enough_s = (median_s.min(stretch_s) / MAX_FACTOR).max(recording.duration_s() / MAX_SAMPLES);
        if !is_short(&dense_s) || enough_s >= median_s {
            Self::Median(median_s)
        } else if dense_s >= enough_s {
            Self::Dense(dense_s)
        } else {
            Self::Limited(enough_s)
        }
    }

    fn interval_s(self) -> f64 {
        match self {
            Self::Median(interval_s) | Self::Dense(interval_s) | Self::Limited(interval_s) => interval_s,
        }
    }

    fn note(self, recording: &Recording) -> String {
        let (min_s, max_s) = recording.interval_range_s();
        let reason = match self {
            Self::Median(_) => "the median interval".to_owned(),
            Self::Dense(_) => format!(
                "the interval of the densest part: the median one, {}, would lose samples there",
                milliseconds(recording.median_interval_s())
            ),
            Self::Limited(_) => format!(
                "which keeps the course of the densest part: the median interval, {}, would lose samples there",
                milliseconds(recording.median_interval_s())
            ),
        };
        format!(
            "The samples are {} to {} apart and are resampled every {}, {reason}.",
            milliseconds(min_s),
            milliseconds(max_s),
            milliseconds(self.interval_s())
        )
    }
}

fn milliseconds(interval_s: f64) -> String {
    format!("{} ms", trocar_document::significant(1e3 * interval_s))
}

pub(super) fn is_even(recording: &Recording) -> bool {
    let interval_s = recording.median_interval_s();
    let is_even = |at_s: f64| (at_s - interval_s).abs() <= EVEN_SHARE * interval_s;
    let (min_s, max_s) = recording.interval_range_s();
    is_even(min_s) && is_even(max_s)
}

/// Resamples an uneven recording linearly.
pub(super) fn samples(recording: Recording) -> Samples {
    let origin = recording.origin_text().map(|origin| format!("Times count from the first sample, at {origin}."));
    let mut notes: Vec<String> = origin.into_iter().chain(recording.joined().iter().map(of_joined)).collect();
    let mut warnings: Vec<Warning> = recording.ignored_units().iter().map(of_ignored_unit).collect();
    warnings.extend(recording.unfinished_warning());
    let as_recorded = |recording: Recording, notes, warnings| {
        let interval_s = recording.median_interval_s();
        let (time_s, position_m, velocity_m_per_s, force_n) = recording.into_columns();
        Samples { interval_s, time_s, position_m, velocity_m_per_s, force_n, is_resampled: false, notes, warnings }
    };
    if is_even(&recording) {
        return as_recorded(recording, notes, warnings);
    }
    let rate = Rate::of(&recording);
    let interval_s = rate.interval_s();
    let resample = |recording: &Recording| {
        let covered = recording.ticks_covered(interval_s)?;
        // One more tick keeps the last sample.
        let rest_s = recording.duration_s() - (covered - 1) as f64 * interval_s;
        let ticks = covered + usize::from(rest_s > EVEN_SHARE * interval_s);
        Ok::<_, ResampleError>((recording.resample(interval_s, ticks)?, ticks))
    };
    let Ok((even, ticks)) = resample(&recording) else { return as_recorded(recording, notes, warnings) };
    notes.push(rate.note(&recording));
    let start_s = recording.time_s().first().copied().unwrap_or(0.0);
    Samples {
        interval_s,
        time_s: (0..ticks).map(|k| start_s + k as f64 * interval_s).collect(),
        position_m: even.position_m,
        velocity_m_per_s: even.velocity_m_per_s,
        force_n: even.force_n,
        is_resampled: true,
        notes,
        warnings,
    }
}

fn of_ignored_unit(ignored: &IgnoredUnit) -> Warning {
    let IgnoredUnit { quantity, column, unit, with_unit } = ignored;
    let (name, si) = (quantity.name(), quantity.unit());
    let message = format!("the {name} is read in {si}, and the file states '{unit}' for the column '{column}'");
    let remedy = format!("give --{name} {with_unit}, or the factor into {si}");
    Warning::new(Code::UnitIgnored, message).at(format!("--{name}")).remedy(remedy)
}

fn of_joined(joined: &Joined) -> String {
    let Joined { signal, to, median_interval_s, longest_interval_s, cut_s } = joined;
    let cut = if *cut_s > 0.0 {
        format!(", and {} s that both do not cover are left out", trocar_document::significant(*cut_s))
    } else {
        String::new()
    };
    format!(
        "'{signal}' has its own clock and is interpolated at the times of '{to}': its samples are {} apart, at most {}{cut}.",
        milliseconds(*median_interval_s),
        milliseconds(*longest_interval_s)
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn recording(time_s: Vec<f64>) -> Recording {
        let force_n = time_s.clone();
        Recording::new(time_s, vec![0.0; force_n.len()], None, force_n, Some(f64::INFINITY)).expect("valid")
    }

    #[test]
    fn a_dense_stretch_sets_the_rate() {
        let coarse = (0..500).map(|k| 0.01 * f64::from(k));
        let dense = |interval_s: f64| (1..51).map(move |k| 4.99 + interval_s * f64::from(k));
        let even = samples(recording(coarse.clone().chain(dense(2e-3)).collect()));
        assert!((even.interval_s - 2e-3).abs() < 1e-9, "{}", even.interval_s);
        assert!((even.force_n.last().expect("samples") - 5.09).abs() < 1e-9);
        assert!(even.notes[0].contains("every 2.000 ms, the interval of the densest part"), "{:?}", even.notes);
        let even = samples(recording(coarse.clone().chain(dense(2e-4)).collect()));
        assert!((even.interval_s - 1e-3).abs() < 1e-9, "a tenth of the median interval, not {}", even.interval_s);
        assert!((even.force_n.last().expect("samples") - 5.0).abs() < 1e-9);
        let few = (1..4).map(|k| 4.99 + 2e-4 * f64::from(k));
        let even = samples(recording(coarse.chain(few).collect()));
        assert!((even.interval_s - 0.01).abs() < 1e-9, "a few short intervals are jitter");
        assert!((even.force_n.last().expect("samples") - 4.9906).abs() < 1e-9, "the last sample is kept");
    }

    #[test]
    fn even_samples_stay_as_they_are() {
        let even = samples(recording((0..100).map(|k| 0.01 * f64::from(k)).collect()));
        assert!(!even.is_resampled && even.notes.is_empty() && even.time_s.len() == 100);
    }

    #[test]
    fn the_number_of_samples_is_limited() {
        let coarse = (0..100).map(|k| f64::from(k) * 100.0);
        let dense = (1..20).map(|k| 9900.0 + 1e-6 * f64::from(k));
        let even = samples(recording(coarse.chain(dense).collect()));
        assert!(even.time_s.len() as f64 <= MAX_SAMPLES + 2.0, "{}", even.time_s.len());
    }
}
