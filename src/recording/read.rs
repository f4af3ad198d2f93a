//! CSV text to samples.

use std::io::{self, BufRead, BufReader, Read};

use csv::ByteRecord;

use super::error::{Place, Problem};
use super::guard::{Guard, recover};
use super::header::{Layout, separator};
use super::number::number;
use super::{Column, Columns, Limits, Recording, RecordingError};

const BUFFER_BYTES: usize = 64 << 10;

/// Reads a recording from CSV text in UTF-8; `source` names it in messages.
///
/// The first line is the header, in which the wanted names must stand once each. The separator is `,`, `;` or tab,
/// whichever the header holds most. Lines that begin with `#`, blank lines (also those of separators only), a byte
/// order mark, any kind of line end, quotes, and spaces around names and numbers are allowed. Numbers have a decimal
/// point and may have an exponent. Columns that are not wanted may hold anything.
///
/// # Errors
/// A [`RecordingError`] with the place and the remedy, when the text is no such table; when a wanted number is missing,
/// malformed or not finite once scaled; when time does not increase strictly or pauses beyond [`Limits::max_gap_s`];
/// when there are fewer than two samples, or more text or samples than the limits allow.
pub fn read_csv<R: Read>(
    source: &str,
    reader: R,
    columns: &Columns,
    limits: &Limits,
) -> Result<Recording, RecordingError> {
    let guard = Guard::new(source, reader, limits.max_bytes);
    let mut text = BufReader::with_capacity(BUFFER_BYTES, guard);
    let (header, lines_before) = header_line(&mut text).map_err(|error| recover(source, error))?;
    let mut rows = Rows {
        source,
        lines_before,
        reader: csv::ReaderBuilder::new()
            .delimiter(separator(&header))
            .has_headers(false)
            .flexible(true)
            .comment(Some(b'#'))
            .buffer_capacity(BUFFER_BYTES)
            .from_reader(header.as_slice().chain(text)),
        record: ByteRecord::new(),
    };
    if !rows.advance()? {
        return Err(Place::file(source).error(Problem::Empty));
    }
    let layout = Layout::locate(rows.record.iter(), columns).map_err(|problem| match problem {
        Problem::NotUtf8 | Problem::NoHeader => rows.place().error(problem),
        _ => Place::file(source).error(problem),
    })?;
    let mut samples = Samples::new(columns, limits);
    while rows.advance()? {
        if !rows.is_blank() {
            samples.push(&rows, &layout)?;
        }
    }
    samples.finish(source)
}

/// The first line that is neither blank nor a comment, without a byte order mark, and how many lines precede it.
fn header_line(text: &mut impl BufRead) -> io::Result<(Vec<u8>, u64)> {
    let mut line = Vec::new();
    let mut lines_before = 0;
    loop {
        line.clear();
        let ended = text.read_until(b'\n', &mut line)? == 0;
        if lines_before == 0 && line.starts_with(b"\xef\xbb\xbf") {
            line.drain(..3);
        }
        let content = line.trim_ascii_start();
        if ended || !(content.is_empty() || content.starts_with(b"#")) {
            return Ok((line, lines_before));
        }
        lines_before += 1;
    }
}

/// The rows of the table, one at a time.
struct Rows<'a, R> {
    source: &'a str,
    lines_before: u64,
    reader: csv::Reader<R>,
    record: ByteRecord,
}

impl<R: Read> Rows<'_, R> {
    fn advance(&mut self) -> Result<bool, RecordingError> {
        let advanced = self.reader.read_byte_record(&mut self.record);
        advanced.map_err(|error| recover(self.source, error.into()))
    }

    /// Blank, or a comment behind spaces.
    fn is_blank(&self) -> bool {
        let text = self.record.as_slice();
        let content = text.trim_ascii_start();
        content.is_empty() || (content.len() < text.len() && content.starts_with(b"#"))
    }

    fn spans_lines(&self) -> bool {
        self.record.as_slice().contains(&b'\n')
    }

    /// The line on which the row begins. The reader knows only how many lines it has consumed, this row's included (its
    /// own count for a row starts before the comments and blank lines that precede it).
    fn line(&self) -> u64 {
        let text = self.record.as_slice();
        let inside = text.iter().filter(|&&byte| byte == b'\n').count() as u64;
        // A quote left open takes in the file's last line end, which then is not the row's.
        let own = u64::from(!text.ends_with(b"\n"));
        (self.lines_before + self.reader.position().line()).saturating_sub(inside + own)
    }

    fn place(&self) -> Place {
        Place::file(self.source).at_line(self.line())
    }

    fn number(&self, index: usize, column: &Column) -> Result<f64, RecordingError> {
        let field = self.record.get(index).unwrap_or_default();
        number(field, column.scale()).map_err(|problem| self.place().in_column(column.name()).error(problem))
    }

    fn check_width(&self, expected: usize) -> Result<(), RecordingError> {
        let found = self.record.len();
        let surplus_is_blank = || self.record.iter().skip(expected).all(|field| field.trim_ascii().is_empty());
        if found == expected || (found > expected && surplus_is_blank()) {
            Ok(())
        } else if self.spans_lines() {
            Err(self.place().error(Problem::OpenQuote))
        } else {
            Err(self.place().error(Problem::RaggedRow { found, expected }))
        }
    }
}

/// The samples so far.
struct Samples<'a> {
    columns: &'a Columns,
    limits: &'a Limits,
    time_s: Vec<f64>,
    position_m: Vec<f64>,
    velocity_m_per_s: Vec<f64>,
    force_n: Vec<f64>,
    lines: Lines,
}

impl<'a> Samples<'a> {
    fn new(columns: &'a Columns, limits: &'a Limits) -> Self {
        Self {
            columns,
            limits,
            time_s: Vec::new(),
            position_m: Vec::new(),
            velocity_m_per_s: Vec::new(),
            force_n: Vec::new(),
            lines: Lines::default(),
        }
    }

    fn push<R: Read>(&mut self, rows: &Rows<'_, R>, layout: &Layout) -> Result<(), RecordingError> {
        let limit = self.limits.max_samples;
        if self.time_s.len() >= limit {
            return Err(rows.place().error(Problem::TooManySamples { limit }));
        }
        rows.check_width(layout.width)?;
        let time_s = rows.number(layout.time, &self.columns.time)?;
        if let Some(&before_s) = self.time_s.last()
            && time_s <= before_s
        {
            let before_line = self.lines.of(self.time_s.len() - 1);
            let place = rows.place().in_column(self.columns.time.name());
            return Err(place.error(not_increasing(before_line, before_s, time_s)));
        }
        self.position_m.push(rows.number(layout.position, &self.columns.position)?);
        if let (Some(index), Some(column)) = (layout.velocity, &self.columns.velocity) {
            self.velocity_m_per_s.push(rows.number(index, column)?);
        }
        self.force_n.push(rows.number(layout.force, &self.columns.force)?);
        self.lines.push(self.time_s.len(), rows.line());
        self.time_s.push(time_s);
        Ok(())
    }

    fn finish(self, source: &str) -> Result<Recording, RecordingError> {
        if self.time_s.len() < 2 {
            return Err(Place::file(source).error(Problem::TooFewSamples(self.time_s.len())));
        }
        let velocity = self.columns.velocity.as_ref().map(|_| self.velocity_m_per_s);
        let recording = Recording::from_checked(self.time_s, self.position_m, velocity, self.force_n);
        let median_s = recording.median_interval_s();
        let limit_s = self.limits.max_gap_s.unwrap_or(Limits::GAP_IN_MEDIANS * median_s);
        let mut pairs = recording.time_s().windows(2);
        // The limit itself is allowed, up to the rounding of times written as decimals; a limit of NaN allows nothing.
        let allowed = |gap_s: f64| gap_s <= limit_s * (1.0 + 1e-9);
        let Some(row) = pairs.position(|pair| !allowed(pair[1] - pair[0])) else {
            return Ok(recording);
        };
        let place = Place::file(source).at_line(self.lines.of(row + 1));
        Err(place.in_column(self.columns.time.name()).error(Problem::Gap {
            before_line: self.lines.of(row),
            before_s: recording.time_s()[row],
            after_s: recording.time_s()[row + 1],
            limit_s,
            median_s: self.limits.max_gap_s.is_none().then_some(median_s),
        }))
    }
}

fn not_increasing(before_line: u64, before_s: f64, after_s: f64) -> Problem {
    if after_s == before_s {
        let time_s = after_s;
        Problem::TimeRepeats { before_line, time_s }
    } else {
        Problem::TimeBackwards { before_line, before_s, after_s }
    }
}

/// The line of each row. Rows mostly follow one another line by line, so only the starts of such runs are kept.
#[derive(Default)]
struct Lines(Vec<(usize, u64)>);

impl Lines {
    fn push(&mut self, row: usize, line: u64) {
        if self.0.is_empty() || self.of(row) != line {
            self.0.push((row, line));
        }
    }

    fn of(&self, row: usize) -> u64 {
        let run = self.0.partition_point(|&(start, _)| start <= row);
        let run = run.checked_sub(1).and_then(|run| self.0.get(run));
        run.map_or(0, |&(start, line)| line + (row - start) as u64)
    }
}

#[cfg(test)]
mod tests;
