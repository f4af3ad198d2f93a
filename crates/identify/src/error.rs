//! Errors of an identification, each with its remedy.

use trocar_recording::{RecordingError, ResampleError};

/// The error of an identification.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum IdentifyError {
    /// A file cannot be read, or a column is missing or has values that are not numbers.
    #[error(transparent)]
    Recording(#[from] RecordingError),
    /// The samples cannot be put on a regular grid.
    #[error("{recording}: {source}")]
    Resample {
        /// The recording.
        recording: String,
        /// The cause.
        source: ResampleError,
    },
    /// Columns have different numbers of samples.
    #[error(
        "{recording}: {column} has {given} values and the time has {expected}; export all columns at the same samples"
    )]
    Length {
        /// The recording.
        recording: String,
        /// The quantity.
        column: &'static str,
        /// The number of its values.
        given: usize,
        /// The number of times.
        expected: usize,
    },
    /// The recording is too short.
    #[error(
        "{recording}: {samples} samples in {duration_s:.3} s, at least 200 samples and 0.2 s are needed; record longer"
    )]
    Short {
        /// The recording.
        recording: String,
        /// The number of samples.
        samples: usize,
        /// The duration in s.
        duration_s: f64,
    },
    /// The master or the slave does not move.
    #[error(
        "{recording}: the {side} does not move (its positions span {span_m:.1e} m), and without motion there is nothing \
         to identify; record a motion with reversals, or check {flag}"
    )]
    NoExcitation {
        /// The recording.
        recording: String,
        /// `master` or `slave`.
        side: &'static str,
        /// The range of the positions in m.
        span_m: f64,
        /// The flag of the column.
        flag: &'static str,
    },
    /// A value is so large that computations with it overflow.
    #[error("{recording}: {column} has the value {value:e} at sample {sample}, must be below 1e9; check its unit")]
    Huge {
        /// The recording.
        recording: String,
        /// The quantity.
        column: &'static str,
        /// The value in SI units.
        value: f64,
        /// The sample, from 0.
        sample: usize,
    },
    /// The force does not change.
    #[error(
        "{recording}: the force does not change (its values span {span_n:.1e} N), and without forces there is nothing to \
         identify; record a contact, or check --force"
    )]
    NoForce {
        /// The recording.
        recording: String,
        /// The range of the forces in N.
        span_n: f64,
    },
    /// No model of the part explains the recordings.
    #[error("{recordings}: {symptom}; {remedy}")]
    Unexplained {
        /// The recordings.
        recordings: String,
        /// What the recordings show.
        symptom: &'static str,
        /// What to check.
        remedy: &'static str,
    },
    /// The tissue ruptures before there are enough samples.
    #[error(
        "{recording}: the force collapses at {at_s:.3} s, as at a rupture, and the part before it is too short; record at \
         least 200 samples and 0.2 s before the rupture"
    )]
    EarlyRupture {
        /// The recording.
        recording: String,
        /// The time of the rupture in s.
        at_s: f64,
    },
    /// The recorded actuator force is not that of a controller with a position gain.
    #[error(
        "the actuator's force does not follow the error between master and slave (position gain {gain_n_per_m:.3e} \
         N/m, explained share {share_percent:.1} %); check the sign and the column of --actuator, or omit it"
    )]
    Actuator {
        /// The estimated position gain in N/m.
        gain_n_per_m: f64,
        /// The explained share of the actuator's force, in %.
        share_percent: f64,
    },
    /// The optimisation found no machine.
    #[error(
        "no machine follows these recordings: every simulation diverges; check that --master and --slave are the same \
         motion in the same unit and sign, and that --force resists the motion"
    )]
    Diverges,
    /// No recording is left for training.
    #[error("no recording to train on; give at least one besides those of --predict")]
    NoTraining,
}

impl IdentifyError {
    pub(crate) fn unexplained<'a>(
        recordings: impl Iterator<Item = &'a str>,
        symptom: &'static str,
        remedy: &'static str,
    ) -> Self {
        let recordings = recordings.collect::<Vec<_>>().join(", ");
        Self::Unexplained { recordings, symptom, remedy }
    }
}
