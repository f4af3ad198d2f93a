//! Errors of `trocar detect`.

use thiserror::Error;

use trocar_recording::RecordingError;

/// An error of a detection.
#[derive(Debug, Error)]
pub(in crate::cli) enum DetectError {
    /// A folder has no recording.
    #[error("{path}: this folder has no *.csv file; name the recordings")]
    EmptyFolder { path: String },
    /// A folder cannot be read.
    #[error("{path}: cannot read the folder: {source}")]
    Folder { path: String, source: std::io::Error },
    /// The file of `--settings` has no settings.
    #[error(
        "{file} has neither [estimator] nor [detector]; give a file that has them, such as calibrated.toml of trocar calibrate"
    )]
    NoSettings { file: String },
    /// `--rupture-s` with several recordings.
    #[error("--rupture-s labels a single recording, but there are {recordings}; use --labels FILE")]
    RupturesOfMany { recordings: usize },
    /// `-` with other recordings.
    #[error("- reads a live stream from standard input; it cannot be combined with recordings")]
    StreamAmongOthers,
    /// A flag for recordings was given with a live stream.
    #[error("{flag} is for recordings, not for a live stream; write the stream to a file and detect in that file")]
    NotForStreams { flag: &'static str },
    /// A flag for live streams was given with recordings.
    #[error("{flag} is for a live stream: trocar detect -")]
    OnlyForStreams { flag: &'static str },
    /// A label file cannot be read, or a stream lacks the requested columns.
    #[error(transparent)]
    Table(#[from] RecordingError),
    /// A label is invalid.
    #[error("{file} line {line}: {problem}")]
    Label {
        file: String,
        line: u64,
        /// The problem, with its remedy.
        problem: LabelProblem,
    },
    /// Some recordings failed. Their errors are already printed.
    #[error("{failed} of {recordings} recordings failed, see above; the others are complete")]
    Some {
        failed: usize,
        recordings: usize,
        /// True if all failures come from invalid input.
        input_at_fault: bool,
    },
    /// A live stream has too few valid samples.
    #[error("standard input: {rows} row{} without the two usable samples that are needed; see --help for the columns", if *rows == 1 { "" } else { "s" })]
    NoSample { rows: u64 },
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
    /// The label names an unknown recording.
    #[error("'{file}' is not one of the given recordings; name it as on the command line, or remove its labels")]
    Unknown {
        /// The file named in the label.
        file: String,
    },
    /// The label's file name matches several recordings.
    #[error("'{file}' matches {first} and {second}; name it as on the command line")]
    Ambiguous {
        /// The file named in the label.
        file: String,
        first: String,
        second: String,
    },
    /// The rupture lies outside the recording.
    #[error(
        "the rupture at {time_s} s is outside the recording, which lasts from {from_s} to {to_s} s in its own time"
    )]
    Outside {
        /// Time of the rupture, in s.
        time_s: f64,
        /// Time of the first sample, in s.
        from_s: f64,
        /// Time of the last sample, in s.
        to_s: f64,
    },
    /// Two labels have the same time.
    #[error("the rupture at {time_s} s is already on line {first_line}; remove one")]
    Twice {
        /// Time of the rupture, s.
        time_s: f64,
        /// Line of the first label.
        first_line: u64,
    },
    /// The label contradicts another label.
    #[error(
        "an empty time means that the recording has no rupture, but line {other_line} labels one; remove one of the two"
    )]
    Contradiction { other_line: u64 },
}

impl DetectError {
    /// Returns true if the error comes from invalid input.
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
