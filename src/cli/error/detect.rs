//! Errors of `trocar detect`.

use thiserror::Error;

use trocar_recording::RecordingError;

/// An error of a detection.
#[derive(Debug, Error)]
pub(in crate::cli) enum DetectError {
    /// A folder has no recording.
    #[error("{path}: this folder has no *.csv file; name the recordings")]
    EmptyFolder {
        /// The folder.
        path: String,
    },
    /// A folder cannot be read.
    #[error("{path}: cannot read the folder: {source}")]
    Folder {
        /// The folder.
        path: String,
        /// The cause.
        source: std::io::Error,
    },
    /// The file of `--settings` has no settings.
    #[error(
        "{file} has neither [estimator] nor [detector]; give a file that has them, such as calibrated.toml of trocar calibrate"
    )]
    NoSettings {
        /// The file.
        file: String,
    },
    /// `--rupture-s` with several recordings.
    #[error("--rupture-s labels a single recording, but there are {recordings}; use --labels FILE")]
    RupturesOfMany {
        /// Number of recordings.
        recordings: usize,
    },
    /// `-` with other recordings.
    #[error("- reads a live stream from standard input; it cannot be combined with recordings")]
    StreamAmongOthers,
    /// A flag for recordings with a live stream.
    #[error("{flag} is for recordings, not for a live stream; write the stream to a file and detect in that file")]
    NotForStreams {
        /// The flag.
        flag: &'static str,
    },
    /// A flag for live streams with recordings.
    #[error("{flag} is for a live stream: trocar detect -")]
    OnlyForStreams {
        /// The flag.
        flag: &'static str,
    },
    /// A file of labels cannot be read, or a stream does not have the requested columns.
    #[error(transparent)]
    Table(#[from] RecordingError),
    /// A label is invalid.
    #[error("{file} line {line}: {problem}")]
    Label {
        /// The file of labels.
        file: String,
        /// The line.
        line: u64,
        /// The problem and its remedy.
        problem: LabelProblem,
    },
    /// Some recordings failed. Their errors are already printed.
    #[error("{failed} of {recordings} recordings failed, see above; the others are complete")]
    Some {
        /// Number of failed recordings.
        failed: usize,
        /// Number of recordings.
        recordings: usize,
        /// Whether all failures come from invalid input.
        input_at_fault: bool,
    },
    /// A live stream has too few valid samples.
    #[error("standard input: {rows} row{} without the two usable samples that are needed; see --help for the columns", if *rows == 1 { "" } else { "s" })]
    NoSample {
        /// Number of rows.
        rows: u64,
    },
    /// Standard input cannot be read.
    #[error("cannot read standard input: {0}")]
    Stream(std::io::Error),
    /// The signal handler cannot be installed.
    #[error("cannot handle signals: {0}")]
    Signals(#[from] ctrlc::Error),
}

/// The problem of a label.
#[derive(Debug, Error)]
pub(in crate::cli) enum LabelProblem {
    /// Its recording is not among the given recordings.
    #[error("'{file}' is not one of the given recordings; name it as on the command line, or remove its labels")]
    Unknown {
        /// The file as in the label.
        file: String,
    },
    /// Its file name matches several recordings.
    #[error("'{file}' matches {first} and {second}; name it as on the command line")]
    Ambiguous {
        /// The file as in the label.
        file: String,
        /// A matching recording.
        first: String,
        /// Another matching recording.
        second: String,
    },
    /// It is before or after the recording.
    #[error(
        "the rupture at {time_s} s is outside the recording, which lasts from {from_s} to {to_s} s in its own time"
    )]
    Outside {
        /// Time of the rupture, s.
        time_s: f64,
        /// Time of the first sample, s.
        from_s: f64,
        /// Time of the last sample, s.
        to_s: f64,
    },
    /// It is a duplicate.
    #[error("the rupture at {time_s} s is already on line {first_line}; remove one")]
    Twice {
        /// Time of the rupture, s.
        time_s: f64,
        /// Line of the first one.
        first_line: u64,
    },
    /// It contradicts another label.
    #[error(
        "an empty time means that the recording has no rupture, but line {other_line} labels one; remove one of the two"
    )]
    Contradiction {
        /// Line of the other label.
        other_line: u64,
    },
}

impl DetectError {
    /// Returns whether the error comes from invalid input.
    pub(in crate::cli) fn is_input(&self) -> bool {
        match self {
            Self::Some { input_at_fault, .. } => *input_at_fault,
            Self::Stream(_) | Self::Signals(_) => false,
            Self::EmptyFolder { .. }
            | Self::Folder { .. }
            | Self::NoSettings { .. }
            | Self::RupturesOfMany { .. }
            | Self::StreamAmongOthers
            | Self::NotForStreams { .. }
            | Self::OnlyForStreams { .. }
            | Self::Table(_)
            | Self::Label { .. }
            | Self::NoSample { .. } => true,
        }
    }
}
