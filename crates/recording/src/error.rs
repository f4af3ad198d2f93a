//! Errors of recordings: place, problem and remedy.

use std::borrow::Cow;
use std::fmt;
use std::io;

use trocar_base::names;

use super::format::Format;
use super::{Limits, Quantity};

/// The error of an unusable recording: `pop.csv line 812, column 'xs_rad': 'abc' is not a number; …`.
#[derive(Debug, thiserror::Error)]
#[error("{place}: {problem}")]
pub struct RecordingError {
    /// Where the problem is.
    pub place: Place,
    /// The problem.
    pub problem: Problem,
}

/// A row of a table or of columns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Row {
    /// The line number as in an editor, from 1.
    Line(u64),
    /// The sample of a signal, from 0.
    Sample(u64),
    /// The row of a spreadsheet, from 1.
    Sheet(u64),
}

impl Row {
    /// The row with a preposition: "on line 3".
    fn on(self) -> String {
        match self {
            Self::Line(_) => format!("on {self}"),
            Self::Sample(_) => format!("at {self}"),
            Self::Sheet(_) => format!("in {self}"),
        }
    }
}

impl fmt::Display for Row {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Line(line) => write!(f, "line {line}"),
            Self::Sample(sample) => write!(f, "sample {sample}"),
            Self::Sheet(row) => write!(f, "row {row}"),
        }
    }
}

/// A place in a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Place {
    /// The file, as the caller named it.
    pub file: Box<str>,
    /// The row or sample; `None` for the whole file.
    pub row: Option<Row>,
    /// The name of the column; `None` if the problem is not in a column.
    pub column: Option<Box<str>>,
}

impl Place {
    pub(super) fn file(file: &str) -> Self {
        Self { file: file.into(), row: None, column: None }
    }

    pub(super) fn at_line(self, line: u64) -> Self {
        self.at(Row::Line(line))
    }

    pub(super) fn at(self, row: Row) -> Self {
        let row = Some(row);
        Self { row, ..self }
    }

    pub(super) fn in_column(self, column: &str) -> Self {
        let column = Some(column.into());
        Self { column, ..self }
    }

    pub(super) fn error(self, problem: Problem) -> RecordingError {
        let place = self;
        RecordingError { place, problem }
    }
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.file)?;
        if let Some(row) = self.row {
            write!(f, " {row}")?;
        }
        if let Some(column) = &self.column {
            write!(f, ", column '{}'", excerpt(column))?;
        }
        Ok(())
    }
}

/// A problem of a recording, with its remedy. Times are in s.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Problem {
    /// The file does not exist, cannot be opened, or failed during reading.
    #[error("cannot be read: {}{}", .0, remedy(.0))]
    Unreadable(io::Error),
    /// A directory, pipe, socket or device, whose reading could block or never end.
    #[error("is a {0}, not a regular file; give the path of a CSV file")]
    NotAFile(&'static str),
    /// The size of the file exceeds the limit; nothing was read.
    #[error(
        "is {} ({size} bytes), the limit is {} ({limit} bytes); keep fewer rows or columns, or raise recording.max_bytes",
        mebibytes(*.size),
        mebibytes(*.limit)
    )]
    TooLarge {
        /// The file's size in bytes.
        size: u64,
        /// The limit in bytes.
        limit: u64,
    },
    /// The content exceeds the limit of a text, or of what a file unpacks to.
    #[error("holds more than {} ({limit} bytes); keep fewer rows or columns, or raise recording.max_bytes", mebibytes(*.limit))]
    TooManyBytes {
        /// The limit in bytes.
        limit: u64,
    },
    /// A part that is longer or deeper than any known recording has.
    #[error("has {part}, the limit is {limit}; write it again with shorter names and fewer levels")]
    OverLimit {
        /// The part with its number.
        part: Box<str>,
        /// The limit of the number.
        limit: usize,
    },
    /// More rows than the limit allows.
    #[error("more than {limit} samples; downsample the recording or raise recording.max_samples")]
    TooManySamples {
        /// The limit in samples.
        limit: usize,
    },
    /// A line longer than the limit.
    #[error("the line is longer than {} bytes; is this a table with one sample per line?", Limits::MAX_LINE_BYTES)]
    LineTooLong,
    /// A zero byte in a text.
    #[error("holds binary data (a zero byte); export it as CSV text in UTF-8")]
    Binary,
    /// A format other than text, in a build without the feature `formats`.
    #[error(
        "is {0}, and this trocar was built without the feature formats; build it with features = [\"formats\"] in Cargo.toml, or \
         export the file as {instead}",
        instead = .0.alternative()
    )]
    Unsupported(Format),
    /// A file that gzip has compressed, in a build without the feature `formats`.
    #[error(
        "is compressed by gzip, and this trocar was built without the feature formats; build it with features = [\"formats\"] in \
         Cargo.toml, or decompress the file with gunzip"
    )]
    GzipUnsupported,
    /// A format that another program converts.
    #[error("is {0}, which trocar does not read; convert it with {how}, and give the new file", how = .0.conversion().unwrap_or_default())]
    NotRead(Format),
    /// A file that gzip has compressed, and whose content is not text.
    #[error("is {0} inside gzip, where only text is read; decompress it with gunzip, and give that file")]
    Gzipped(Format),
    /// A file that is truncated, damaged, or uses an unsupported part of its format.
    #[error("is {format} that cannot be read: {detail}; write it again, or export it as {}", .format.alternative())]
    Damaged {
        /// The format.
        format: Format,
        /// The defect.
        detail: Box<str>,
    },
    /// The file has no signals.
    #[error("is {format} without a signal: no array of numbers with at least two samples{left_out}")]
    NoSignal {
        /// The format.
        format: Format,
        /// The parts of the file that are no signals, with the reason; may be empty.
        left_out: Box<str>,
    },
    /// A requested signal is missing in a file of arrays.
    #[error(
        "no signal '{}'{}; the file has {}{}; `trocar detect FILE --list` shows all",
        excerpt(.name),
        asked_by(*.quantity),
        listing(.available),
        suggestion(.nearest.as_deref())
    )]
    MissingSignal {
        /// The requested name.
        name: Box<str>,
        /// The file's signals, in order.
        available: Vec<String>,
        /// The most similar name, if similar enough.
        nearest: Option<Box<str>>,
        /// The requested quantity.
        quantity: Option<Quantity>,
    },
    /// A short name that matches several signals.
    #[error("'{}' is ambiguous: it can be {}; give one of these names", excerpt(.name), listing(.candidates))]
    AmbiguousSignal {
        /// The requested name.
        name: Box<str>,
        /// The matching signals.
        candidates: Vec<String>,
    },
    /// An array with several signals was requested without a column, or with a column that it does not have.
    #[error("'{}' is {shape}, not one signal; give its column, counted from 0, as in {}", excerpt(.name), excerpt(.example))]
    NotOneSignal {
        /// The requested name.
        name: Box<str>,
        /// The array's size, as in "5810 x 2".
        shape: Box<str>,
        /// The name of one of the signals.
        example: Box<str>,
    },
    /// A signal with a different number of samples than the time.
    #[error(
        "has {samples} samples, and the time '{}' has {times}; give signals of one clock: with {times} samples the file has {}",
        excerpt(.time),
        listing(.fitting)
    )]
    Lengths {
        /// Number of samples of the signal.
        samples: usize,
        /// Number of samples of the time.
        times: usize,
        /// The name of the time signal.
        time: Box<str>,
        /// The signals with as many samples as the time.
        fitting: Vec<String>,
    },
    /// A signal of another topic than the time, which is not a time of the whole log.
    #[error("is of another topic than the time '{}', which may count from another start; give --time {shared}, which all topics share", excerpt(.time))]
    Clocks {
        /// The name of the time signal.
        time: Box<str>,
        /// The time that both share.
        shared: Box<str>,
    },
    /// Signals of different clocks without a time in common.
    #[error("the signals have no two samples in common time by '{}'; give signals that were recorded at the same time", excerpt(.time))]
    NoCommonTime {
        /// The name of the time signal.
        time: Box<str>,
        /// The time signal of the file.
        shared: Box<str>,
    },
    /// A position, velocity or force that no needle has.
    #[error(
        "is {value:e} {0}, at most {1:e} {0}; correct it, or give the unit or the factor of the column",
        .quantity.unit(),
        Limits::MAX_MAGNITUDE
    )]
    TooBig {
        /// The value in SI units.
        value: f64,
        /// The quantity.
        quantity: Quantity,
    },
    /// NaN or an empty cell.
    #[error("holds no finite number (NaN or empty); correct it or remove the sample")]
    Undefined,
    /// Both decimal points and decimal commas in one file.
    #[error("'{0}' and earlier numbers mix decimal points and decimal commas; write all decimals with a point")]
    MixedDecimals(
        /// The field.
        Box<str>,
    ),
    /// A LabVIEW header without its end or its columns.
    #[error("the LabVIEW header is incomplete: no line of columns (X_Value, …) follows it; export the file again")]
    LabViewHeader,
    /// Bytes that are not UTF-8 in the header or in a requested column.
    #[error("the text is not UTF-8; save the file as CSV in UTF-8")]
    NotUtf8,
    /// The file contains only blank lines and comments.
    #[error("holds no data; a header line with the columns' names is expected, then one sample per line")]
    Empty,
    /// The first line that is not a comment contains only numbers.
    #[error(
        "numbers where the columns' names are expected; add a header line (a line that begins with '#' is a comment)"
    )]
    NoHeader,
    /// A requested column is missing in the header.
    #[error(
        "no column '{}'{}; the file has {}{}",
        excerpt(.name),
        asked_by(*.quantity),
        listing(.available),
        suggestion(.nearest.as_deref())
    )]
    MissingColumn {
        /// The requested name.
        name: Box<str>,
        /// The file's names, in order.
        available: Vec<String>,
        /// The most similar name, if similar enough.
        nearest: Option<Box<str>>,
        /// The requested quantity, in a recording.
        quantity: Option<Quantity>,
    },
    /// A requested column is missing in a table without names.
    #[error(
        "no column '{}'{}: the file has no line of names, so that its {count} columns are named by their numbers; \
         give them as in --time 1 --position 2 --force 3, or add a line of names",
        excerpt(.name),
        asked_by(Some(*.quantity))
    )]
    UnnamedColumns {
        /// The requested name.
        name: Box<str>,
        /// The requested quantity.
        quantity: Quantity,
        /// Number of columns.
        count: usize,
    },
    /// The text after the name of a column is not a unit of its quantity.
    #[error(
        "'{}' is not a known unit of {}; give {}, or a factor into {}",
        excerpt(.unit),
        .quantity.name(),
        .quantity.units(),
        .quantity.unit()
    )]
    UnknownUnit {
        /// The text.
        unit: Box<str>,
        /// The quantity.
        quantity: Quantity,
    },
    /// The header contains a requested name more than once.
    #[error("{count} columns are named '{}'; rename all but one, or give the number of the column, from 1", excerpt(.name))]
    AmbiguousColumn {
        /// The requested name.
        name: Box<str>,
        /// Number of columns with this name, at least 2.
        count: usize,
    },
    /// Fewer than two rows follow the header.
    #[error("holds {}; at least two are needed", if *.0 == 0 { "a header but no samples" } else { "a single sample" })]
    TooFewSamples(usize),
    /// A row with a different number of fields than the header.
    #[error(
        "the row has {found} fields, the header {expected}; complete or remove the row (decimals need a point, not a comma)"
    )]
    RaggedRow {
        /// Number of fields in the row.
        found: usize,
        /// Number of fields in the header.
        expected: usize,
    },
    /// A quoted field that continues past the end of its line.
    #[error("a quoted field continues past the end of the line; close the quote")]
    OpenQuote,
    /// A requested field is empty.
    #[error("the field is empty; fill in a number or remove the row")]
    EmptyField,
    /// A table whose columns contain only texts.
    #[error(
        "no column has a number: the columns are {}; is the table below other lines (--skip-lines N), or is its separator none of \
         comma, semicolon, tab and space?",
        listing(.names)
    )]
    NoNumbers {
        /// The names of the columns.
        names: Vec<String>,
    },
    /// Text where a number is expected.
    #[error("'{}' is not a number; {}", .0, advice(.0))]
    NotANumber(
        /// The field, shortened if it is long.
        Box<str>,
    ),
    /// A delay that is negative or too long.
    #[error(
        "a delay of {delay_s} s, must be from 0 to {max_s} s; correct it, or leave the field empty if the sample was lost"
    )]
    DelayOutOfRange {
        /// The delay in s.
        delay_s: f64,
        /// The maximum delay in s.
        max_s: f64,
    },
    /// A frequency that is not above 0 and above the one before it.
    #[error("{frequency_hz} Hz after {last_hz} Hz, must be above it; sort the rows, and leave out 0 Hz")]
    FrequencyOutOfOrder {
        /// The frequency in Hz.
        frequency_hz: f64,
        /// The one before it in Hz; 0 before the first.
        last_hz: f64,
    },
    /// A magnitude that is not above 0, or too large in decibels.
    #[error("a magnitude of {0}, must be finite and above 0; write decibels in a column magnitude_db")]
    MagnitudeOutOfRange(
        /// The magnitude as written.
        f64,
    ),
    /// A frequency response with too few rows.
    #[error("holds {0} frequencies; at least three are needed")]
    TooFewFrequencies(
        /// Number of frequencies.
        usize,
    ),
    /// NaN, an infinity, or a number that overflows when scaled.
    #[error("'{text}' is not finite{}; correct it or remove the row", scaled(*.scale))]
    NotFinite {
        /// The field, shortened if it is long.
        text: Box<str>,
        /// The column's scale.
        scale: f64,
    },
    /// A number in SI units that exceeds [`Limits::MAX_MAGNITUDE`].
    #[error("{value:e} in SI units, at most {limit:e}; correct it, or the column's factor")]
    TooGreat {
        /// The number.
        value: f64,
        /// The limit.
        limit: f64,
    },
    /// A time beyond the calendar, which has another unit than the stated one.
    #[error(
        "{time_s:e} s is no time of the calendar; give its unit after a colon, as in --time timestamp:ns, :us or :ms"
    )]
    TimeBeyondCalendar {
        /// The time in s.
        time_s: f64,
    },
    /// The time of a sample is before the previous time.
    #[error(
        "time decreases, from {before_s} s {} to {after_s} s; sort the rows by time, or keep one run per file",
        .before.on()
    )]
    TimeBackwards {
        /// The row of the previous sample.
        before: Row,
        /// The previous time in s.
        before_s: f64,
        /// The time in s.
        after_s: f64,
    },
    /// The time of a sample equals the previous time.
    #[error("the time {time_s} s repeats that of {before}; remove the repeated row, or log time with more digits")]
    TimeRepeats {
        /// The row of the previous sample.
        before: Row,
        /// The time of both samples in s.
        time_s: f64,
    },
    /// A gap longer than the limit.
    #[error(
        "no sample for {} s since {before} (from {before_s} s to {after_s} s), the limit is {} s{}; cut the recording there, or raise max_gap_s",
        six_digits(.after_s - .before_s),
        six_digits(*.limit_s),
        median(*.median_s)
    )]
    Gap {
        /// The row of the last sample before the gap.
        before: Row,
        /// Its time in s.
        before_s: f64,
        /// The time of the first sample after the gap, in s.
        after_s: f64,
        /// The maximum gap in s.
        limit_s: f64,
        /// The median interval in s, if the limit is derived from it.
        median_s: Option<f64>,
    },
}

impl Format {
    pub(super) fn damaged(self, detail: impl fmt::Display) -> Problem {
        Problem::Damaged { format: self, detail: line(&detail.to_string()).into() }
    }
}

impl Problem {
    /// The problem of a file without a signal, with the parts that are left out.
    pub(super) fn no_signal(format: Format, left_out: &[String]) -> Self {
        let left_out = if left_out.is_empty() { String::new() } else { format!(" ({})", listing(left_out)) };
        Self::NoSignal { format, left_out: left_out.into() }
    }
}

/// Shortens `text` to at most 40 characters on one line, for messages.
pub(super) fn excerpt(text: &str) -> String {
    const MAX_CHARACTERS: usize = 40;
    let mut shown: String = text.chars().take(MAX_CHARACTERS).flat_map(char::escape_debug).collect();
    if text.chars().nth(MAX_CHARACTERS).is_some() {
        shown.push('…');
    }
    shown
}

/// Converts a library's message to one line, shortened if it is long.
fn line(text: &str) -> String {
    const MAX_CHARACTERS: usize = 200;
    let words: Vec<Cow<'_, str>> = text.split_whitespace().take(MAX_CHARACTERS).map(names::shortened).collect();
    let mut shown: String =
        words.join(" ").chars().filter(|character| !character.is_control()).take(MAX_CHARACTERS).collect();
    if shown.ends_with('.') {
        shown.pop();
    }
    shown
}

fn listing(names: &[String]) -> String {
    const MAX_NAMES: usize = 12;
    let mut shown: Vec<String> = names.iter().take(MAX_NAMES).map(|name| excerpt(name)).collect();
    if names.len() > MAX_NAMES {
        shown.push(format!("and {} more", names.len() - MAX_NAMES));
    }
    shown.join(", ")
}

fn asked_by(quantity: Option<Quantity>) -> String {
    quantity.map_or_else(String::new, |quantity| format!(" (--{} or {})", quantity.name(), quantity.key()))
}

fn suggestion(nearest: Option<&str>) -> String {
    nearest.map_or_else(String::new, |name| format!("; did you mean '{}'?", excerpt(name)))
}

fn scaled(scale: f64) -> String {
    if scale == 1.0 { String::new() } else { format!(" (with scale {scale})") }
}

fn median(median_s: Option<f64>) -> String {
    median_s.map_or_else(String::new, |median_s| {
        let times = Limits::GAP_IN_MEDIANS;
        format!(" ({times} times the median interval, {} s)", six_digits(median_s))
    })
}

fn remedy(error: &io::Error) -> &'static str {
    if error.kind() == io::ErrorKind::NotFound { "; give the path of an existing file" } else { "" }
}

fn mebibytes(bytes: u64) -> String {
    format!("{:.1} MiB", bytes as f64 / f64::from(1 << 20))
}

/// Rounds to six significant digits, so that differences of decimals are shown as decimals.
fn six_digits(value: f64) -> f64 {
    format!("{value:.5e}").parse().unwrap_or(value)
}

/// The remedy for a text that is not a number.
fn advice(text: &str) -> &'static str {
    // Excerpts contain escaped characters.
    let text = [("\\'", "'"), ("\\u{a0}", " "), ("\\u{202f}", " ")]
        .iter()
        .fold(text.to_owned(), |text, (from, to)| text.replace(from, to));
    let separators: Vec<char> =
        text.trim().chars().filter(|c| matches!(c, '.' | ',' | '\'' | '’' | ' ' | '\u{a0}' | '\u{202f}')).collect();
    let is_of_digits = text.chars().all(|c| c.is_ascii_digit() || "+-eE".contains(c) || separators.contains(&c));
    let has_point_or_comma = separators.iter().any(|c| matches!(c, '.' | ','));
    if is_of_digits && (separators.len() > 1 || !separators.is_empty() && !has_point_or_comma) {
        "write it without thousands separators"
    } else if text.contains(',') {
        "write decimals with a point"
    } else {
        "correct it or remove the row"
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_stay_short_and_on_one_line() {
        assert_eq!(excerpt("a\nb\u{7}"), "a\\nb\\u{7}");
        assert_eq!(excerpt(&"x".repeat(1000)).chars().count(), 41);
        let names: Vec<String> = (0..14).map(|i| format!("c{i}")).collect();
        assert!(listing(&names).ends_with("c11, and 2 more"));
    }

    #[test]
    fn differences_read_as_decimals() {
        assert_eq!(six_digits(0.605 - 0.405), 0.2);
        assert_eq!(six_digits(f64::INFINITY), f64::INFINITY);
    }

    #[test]
    fn the_error_stays_small_enough_to_return() {
        assert!(size_of::<RecordingError>() < 128);
    }
}
