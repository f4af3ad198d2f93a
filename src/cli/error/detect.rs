//! What stops a detection.

use thiserror::Error;

use trocar_sim::recording::RecordingError;

/// Why a detection ended early, or ended with something left undone.
#[derive(Debug, Error)]
pub(in crate::cli) enum DetectError {
    /// A folder without a recording.
    #[error("{path}: no *.csv file in this folder; name the recordings")]
    EmptyFolder {
        /// The folder.
        path: String,
    },
    /// A folder that cannot be listed.
    #[error("{path}: the folder cannot be read: {source}")]
    Folder {
        /// The folder.
        path: String,
        /// Why.
        source: std::io::Error,
    },
    /// `--settings` with a file that has none.
    #[error(
        "{file}: neither [estimator] nor [detector] in it; give a file that has them, as calibrated.toml of trocar calibrate"
    )]
    NothingTuned {
        /// The file.
        file: String,
    },
    /// `--rupture-s` with several recordings.
    #[error("--rupture-s labels a single recording, and there are {recordings}; give --labels FILE")]
    RupturesOfMany {
        /// How many there are.
        recordings: usize,
    },
    /// `-` beside recordings.
    #[error("- reads a live stream from standard input; it goes with no other recording")]
    StreamAmongOthers,
    /// A flag that only recordings know.
    #[error("{flag} is for recordings, not for a live stream; store the stream and detect in the file")]
    NotForStreams {
        /// The flag.
        flag: &'static str,
    },
    /// A flag that only live streams know.
    #[error("{flag} is for a live stream: trocar detect -")]
    OnlyForStreams {
        /// The flag.
        flag: &'static str,
    },
    /// A file of labels that cannot be read, or a stream without the wanted columns.
    #[error(transparent)]
    Table(#[from] RecordingError),
    /// A label that cannot be used.
    #[error("{file} line {line}: {problem}")]
    Label {
        /// The file of labels.
        file: String,
        /// The line.
        line: u64,
        /// What is wrong, and the remedy.
        problem: LabelProblem,
    },
    /// Some recordings could not be used; each has been reported.
    #[error("{failed} of {recordings} recordings failed, see above; the others are done")]
    Some {
        /// How many failed.
        failed: usize,
        /// Of how many.
        recordings: usize,
        /// Whether only their input was at fault.
        input_at_fault: bool,
    },
    /// A live stream without a usable sample.
    #[error("standard input: {rows} rows and no sample that could be used, two are needed; see --help for the columns")]
    NoSample {
        /// How many rows there were.
        rows: u64,
    },
    /// A live stream that broke.
    #[error("standard input cannot be read: {0}")]
    Stream(std::io::Error),
    /// Ctrl-C could not be taken over.
    #[error("signals cannot be handled: {0}")]
    Signals(#[from] ctrlc::Error),
}

/// What is wrong with a label.
#[derive(Debug, Error)]
pub(in crate::cli) enum LabelProblem {
    /// Its recording is none of those given.
    #[error("'{file}' is none of the recordings given; name it as on the command line, or leave its labels out")]
    Unknown {
        /// The file as it was written.
        file: String,
    },
    /// Its recording could be one of several.
    #[error("'{file}' could be {first} or {second}; write it as on the command line")]
    Ambiguous {
        /// The file as it was written.
        file: String,
        /// One that it could be.
        first: String,
        /// Another one.
        second: String,
    },
    /// It lies before or after the recording.
    #[error("a rupture at {time_s} s, must be within the recording, from {from_s} to {to_s} s in its own time")]
    Outside {
        /// When.
        time_s: f64,
        /// The first sample's time.
        from_s: f64,
        /// The last one's.
        to_s: f64,
    },
    /// It is there already.
    #[error("a rupture at {time_s} s again, as on line {first_line}; remove one")]
    Twice {
        /// When.
        time_s: f64,
        /// Where it was first.
        first_line: u64,
    },
    /// It says that there is no rupture, and another one that there is.
    #[error("an empty time says that the recording has no rupture, but line {other_line} labels one; remove either")]
    Contradiction {
        /// The other one.
        other_line: u64,
    },
}

impl DetectError {
    /// Whether what the user gave is at fault.
    pub(in crate::cli) fn is_input(&self) -> bool {
        match self {
            Self::Some { input_at_fault, .. } => *input_at_fault,
            Self::Stream(_) | Self::Signals(_) => false,
            _ => true,
        }
    }
}
