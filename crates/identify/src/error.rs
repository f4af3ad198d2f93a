use trocar_recording::{RecordingError, ResampleError};

#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum IdentifyError {
    #[error(transparent)]
    Recording(#[from] RecordingError),
    #[error("{recording}: {source}")]
    Resample {
        /// Path or name.
        recording: String,
        source: ResampleError,
    },
    #[error(
        "{recording}: {column} has {given} values and the time has {expected}; export all columns at the same samples"
    )]
    Length {
        recording: String,
        column: &'static str,
        /// Values of the column.
        given: usize,
        expected: usize,
    },
    #[error(
        "{recording}: {samples} samples in {duration_s:.3} s, at least 200 samples and 0.2 s are needed; record longer"
    )]
    Short {
        recording: String,
        samples: usize,
        /// To the last sample.
        duration_s: f64,
    },
    #[error(
        "{recording}: the {side} does not move (its positions span {span_m:.1e} m), and without motion there is nothing \
         to identify; record a motion with reversals, or check {flag}"
    )]
    NoExcitation {
        recording: String,
        /// `master` or `slave`.
        side: &'static str,
        span_m: f64,
        flag: &'static str,
    },
    #[error("{recording}: {column} has the value {value:e} at sample {sample}, must be below 1e9; check its unit")]
    Huge {
        recording: String,
        column: &'static str,
        /// In SI units.
        value: f64,
        /// From 0.
        sample: usize,
    },
    #[error(
        "{recording}: the force does not change (its values span {span_n:.1e} N), and without forces there is nothing to \
         identify; record a contact, or check --force"
    )]
    NoForce {
        recording: String,
        /// Range of the values.
        span_n: f64,
    },
    #[error("{recordings}: {symptom}; {remedy}")]
    Unexplained {
        recordings: String,
        /// Shown by the recordings.
        symptom: &'static str,
        remedy: &'static str,
    },
    #[error(
        "{recording}: the force collapses at {at_s:.3} s, as at a rupture, and the part before it is too short; record at \
         least 200 samples and 0.2 s before the rupture"
    )]
    EarlyRupture {
        recording: String,
        /// From the first sample.
        at_s: f64,
    },
    #[error(
        "the actuator's force does not follow the error between master and slave (position gain {gain_n_per_m:.3e} \
         N/m, explained share {share_percent:.1} %); check the sign and the column of --actuator, or omit it"
    )]
    Actuator {
        /// Estimated.
        gain_n_per_m: f64,
        share_percent: f64,
    },
    #[error(
        "no machine follows these recordings: every simulation diverges; check that --master and --slave are the same \
         motion in the same unit and sign, and that --force resists the motion"
    )]
    Diverges,
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
