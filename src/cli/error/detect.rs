use thiserror::Error;

use trocar_recording::RecordingError;

#[derive(Debug, Error)]
pub(in crate::cli) enum DetectError {
    #[error("{path}: this folder has no *.csv file; name the recordings")]
    EmptyFolder { path: String },
    #[error("{path}: cannot read the folder: {source}")]
    Folder { path: String, source: std::io::Error },
    #[error(
        "{file} has neither [estimator] nor [detector]; give a file that has them, such as calibrated.toml of trocar calibrate"
    )]
    NoSettings { file: String },
    #[error("--rupture-s labels a single recording, but there are {recordings}; use --labels FILE")]
    RupturesOfMany { recordings: usize },
    #[error("- reads a live stream from standard input; it cannot be combined with recordings")]
    StreamAmongOthers,
    #[error("{flag} is for recordings, not for a live stream; write the stream to a file and detect in that file")]
    NotForStreams { flag: &'static str },
    #[error("{flag} is for a live stream: trocar detect -")]
    OnlyForStreams { flag: &'static str },
    #[error(transparent)]
    Table(#[from] RecordingError),
    #[error("{file} line {line}: {problem}")]
    Label { file: String, line: u64, problem: LabelProblem },
    /// Their errors are already printed.
    #[error("{failed} of {recordings} recordings failed, see above; the others are complete")]
    Some {
        failed: usize,
        recordings: usize,
        /// True if all failures come from invalid input.
        input_at_fault: bool,
    },
    #[error("standard input: {rows} row{} without the two usable samples that are needed; see --help for the columns", if *rows == 1 { "" } else { "s" })]
    NoSample { rows: u64 },
    #[error("cannot read standard input: {0}")]
    Stream(std::io::Error),
}

#[derive(Debug, Error)]
pub(in crate::cli) enum LabelProblem {
    #[error("'{file}' is not one of the given recordings; name it as on the command line, or remove its labels")]
    Unknown { file: String },
    #[error("'{file}' matches {first} and {second}; name it as on the command line")]
    Ambiguous { file: String, first: String, second: String },
    #[error(
        "the rupture at {time_s} s is outside the recording, which lasts from {from_s} to {to_s} s in its own time"
    )]
    Outside { time_s: f64, from_s: f64, to_s: f64 },
    #[error("the rupture at {time_s} s is already on line {first_line}; remove one")]
    Twice { time_s: f64, first_line: u64 },
    #[error(
        "an empty time means that the recording has no rupture, but line {other_line} labels one; remove one of the two"
    )]
    Contradiction { other_line: u64 },
}

impl DetectError {
    pub(in crate::cli) fn is_input(&self) -> bool {
        match self {
            Self::Some { input_at_fault, .. } => *input_at_fault,
            Self::Stream(_) => false,
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
