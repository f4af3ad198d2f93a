use std::borrow::Cow;
use std::fmt;
use std::io;

use trocar_base::names;

use super::format::Format;
use super::{Limits, Quantity};

#[derive(Debug, thiserror::Error)]
#[error("{place}: {problem}")]
pub struct RecordingError {
    pub place: Place,
    pub problem: Problem,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Row {
    /// From 1.
    Line(u64),
    /// From 0.
    Sample(u64),
    /// The row of a spreadsheet, from 1.
    Sheet(u64),
}

impl Row {
    /// With a preposition: "on line 3".
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

#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Place {
    pub file: Box<str>,
    pub row: Option<Row>,
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

/// Times are in s.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Problem {
    #[error("cannot be read: {}{}", .0, remedy(.0))]
    Unreadable(io::Error),
    #[error("is a {0}, not a regular file; give the path of a CSV file")]
    NotAFile(&'static str),
    #[error(
        "is {} ({size} bytes), the limit is {} ({limit} bytes); keep fewer rows or columns, or raise recording.max_bytes",
        mebibytes(*.size),
        mebibytes(*.limit)
    )]
    TooLarge { size: u64, limit: u64 },
    #[error("holds more than {} ({limit} bytes); keep fewer rows or columns, or raise recording.max_bytes", mebibytes(*.limit))]
    TooManyBytes { limit: u64 },
    #[error("has {part}, the limit is {limit}; write it again with shorter names and fewer levels")]
    OverLimit { part: Box<str>, limit: usize },
    #[error("more than {limit} samples; downsample the recording or raise recording.max_samples")]
    TooManySamples { limit: usize },
    #[error("the line is longer than {} bytes; is this a table with one sample per line?", Limits::MAX_LINE_BYTES)]
    LineTooLong,
    #[error("holds binary data (a zero byte); export it as CSV text in UTF-8")]
    Binary,
    #[error(
        "is {0}, and this trocar was built without the feature formats; build it with features = [\"formats\"] in Cargo.toml, or \
         export the file as {instead}",
        instead = .0.alternative()
    )]
    Unsupported(Format),
    #[error(
        "is compressed by gzip, and this trocar was built without the feature formats; build it with features = [\"formats\"] in \
         Cargo.toml, or decompress the file with gunzip"
    )]
    GzipUnsupported,
    #[error("is {0}, which trocar does not read; convert it with {how}, and give the new file", how = .0.conversion().unwrap_or_default())]
    NotRead(Format),
    #[error("is {0} inside gzip, where only text is read; decompress it with gunzip, and give that file")]
    Gzipped(Format),
    #[error("is {format} that cannot be read: {detail}; write it again, or export it as {}", .format.alternative())]
    Damaged { format: Format, detail: Box<str> },
    #[error("is {format} without a signal: no array of numbers with at least two samples{left_out}")]
    NoSignal { format: Format, left_out: Box<str> },
    #[error(
        "no signal '{}'{}; the file has {}{}; `trocar detect FILE --list` shows all",
        excerpt(.name),
        asked_by(*.quantity),
        listing(.available),
        suggestion(.nearest.as_deref())
    )]
    MissingSignal { name: Box<str>, available: Vec<String>, nearest: Option<Box<str>>, quantity: Option<Quantity> },
    #[error("'{}' is ambiguous: it can be {}; give one of these names", excerpt(.name), listing(.candidates))]
    AmbiguousSignal { name: Box<str>, candidates: Vec<String> },
    #[error("'{}' is {shape}, not one signal; give its column, counted from 0, as in {}", excerpt(.name), excerpt(.example))]
    NotOneSignal { name: Box<str>, shape: Box<str>, example: Box<str> },
    #[error(
        "has {samples} samples, and the time '{}' has {times}; give signals of one clock: with {times} samples the file has {}",
        excerpt(.time),
        listing(.fitting)
    )]
    Lengths { samples: usize, times: usize, time: Box<str>, fitting: Vec<String> },
    #[error("is of another topic than the time '{}', which may count from another start; give --time {shared}, which all topics share", excerpt(.time))]
    Clocks { time: Box<str>, shared: Box<str> },
    #[error("the signals have no two samples in common time by '{}'; give signals that were recorded at the same time", excerpt(.time))]
    NoCommonTime { time: Box<str>, shared: Box<str> },
    #[error(
        "is {value:e} {0}, at most {1:e} {0}; correct it, or give the unit or the factor of the column",
        .quantity.unit(),
        Limits::MAX_MAGNITUDE
    )]
    TooBig { value: f64, quantity: Quantity },
    #[error("holds no finite number (NaN or empty); correct it or remove the sample")]
    Undefined,
    #[error("'{0}' and earlier numbers mix decimal points and decimal commas; write all decimals with a point")]
    MixedDecimals(Box<str>),
    #[error("the LabVIEW header is incomplete: no line of columns (X_Value, …) follows it; export the file again")]
    LabViewHeader,
    #[error("the text is not UTF-8; save the file as CSV in UTF-8")]
    NotUtf8,
    #[error("holds no data; a header line with the columns' names is expected, then one sample per line")]
    Empty,
    #[error(
        "numbers where the columns' names are expected; add a header line (a line that begins with '#' is a comment)"
    )]
    NoHeader,
    #[error(
        "no column '{}'{}; the file has {}{}",
        excerpt(.name),
        asked_by(*.quantity),
        listing(.available),
        suggestion(.nearest.as_deref())
    )]
    MissingColumn { name: Box<str>, available: Vec<String>, nearest: Option<Box<str>>, quantity: Option<Quantity> },
    #[error(
        "no column '{}'{}: the file has no line of names, so that its {count} columns are named by their numbers; \
         give them as in --time 1 --position 2 --force 3, or add a line of names",
        excerpt(.name),
        asked_by(Some(*.quantity))
    )]
    UnnamedColumns { name: Box<str>, quantity: Quantity, count: usize },
    #[error(
        "'{}' is not a known unit of {}; give {}, or a factor into {}",
        excerpt(.unit),
        .quantity.name(),
        .quantity.units(),
        .quantity.unit()
    )]
    UnknownUnit { unit: Box<str>, quantity: Quantity },
    #[error("{count} columns are named '{}'; rename all but one, or give the number of the column, from 1", excerpt(.name))]
    AmbiguousColumn { name: Box<str>, count: usize },
    #[error("holds {}; at least two are needed", if *.0 == 0 { "a header but no samples" } else { "a single sample" })]
    TooFewSamples(usize),
    #[error(
        "the row has {found} fields, the header {expected}; complete or remove the row (decimals need a point, not a comma)"
    )]
    RaggedRow { found: usize, expected: usize },
    #[error("a quoted field continues past the end of the line; close the quote")]
    OpenQuote,
    #[error("the field is empty; fill in a number or remove the row")]
    EmptyField,
    #[error(
        "no column has a number: the columns are {}; is the table below other lines (--skip-lines N), or is its separator none of \
         comma, semicolon, tab and space?",
        listing(.names)
    )]
    NoNumbers { names: Vec<String> },
    #[error("'{}' is not a number; {}", .0, advice(.0))]
    NotANumber(Box<str>),
    #[error(
        "a delay of {delay_s} s, must be from 0 to {max_s} s; correct it, or leave the field empty if the sample was lost"
    )]
    DelayOutOfRange { delay_s: f64, max_s: f64 },
    #[error("{frequency_hz} Hz after {last_hz} Hz, must be above it; sort the rows, and leave out 0 Hz")]
    FrequencyOutOfOrder { frequency_hz: f64, last_hz: f64 },
    #[error("a magnitude of {0}, must be finite and above 0; write decibels in a column magnitude_db")]
    MagnitudeOutOfRange(f64),
    #[error("holds {0} frequencies; at least three are needed")]
    TooFewFrequencies(usize),
    #[error("'{text}' is not finite{}; correct it or remove the row", scaled(*.scale))]
    NotFinite { text: Box<str>, scale: f64 },
    #[error("{value:e} in SI units, at most {limit:e}; correct it, or the column's factor")]
    TooGreat { value: f64, limit: f64 },
    #[error(
        "{time_s:e} s is no time of the calendar; give its unit after a colon, as in --time timestamp:ns, :us or :ms"
    )]
    TimeBeyondCalendar { time_s: f64 },
    #[error(
        "time decreases, from {before_s} s {} to {after_s} s; sort the rows by time, or keep one run per file",
        .before.on()
    )]
    TimeBackwards { before: Row, before_s: f64, after_s: f64 },
    #[error("the time {time_s} s repeats that of {before}; remove the repeated row, or log time with more digits")]
    TimeRepeats { before: Row, time_s: f64 },
    #[error(
        "no sample for {} s since {before} (from {before_s} s to {after_s} s), the limit is {} s{}; cut the recording there, or raise max_gap_s",
        six_digits(.after_s - .before_s),
        six_digits(*.limit_s),
        median(*.median_s)
    )]
    Gap { before: Row, before_s: f64, after_s: f64, limit_s: f64, median_s: Option<f64> },
}

impl Format {
    pub(super) fn damaged(self, detail: impl fmt::Display) -> Problem {
        Problem::Damaged { format: self, detail: line(&detail.to_string()).into() }
    }
}

impl Problem {
    pub(super) fn no_signal(format: Format, left_out: &[String]) -> Self {
        let left_out = if left_out.is_empty() { String::new() } else { format!(" ({})", listing(left_out)) };
        Self::NoSignal { format, left_out: left_out.into() }
    }
}

pub(super) fn excerpt(text: &str) -> String {
    const MAX_CHARACTERS: usize = 40;
    let mut shown: String = text.chars().take(MAX_CHARACTERS).flat_map(char::escape_debug).collect();
    if text.chars().nth(MAX_CHARACTERS).is_some() {
        shown.push('…');
    }
    shown
}

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

/// Shows differences of decimals as decimals.
fn six_digits(value: f64) -> f64 {
    format!("{value:.5e}").parse().unwrap_or(value)
}

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
