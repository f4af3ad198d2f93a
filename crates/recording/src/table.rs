use std::io::{BufReader, Chain, Cursor, Read};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};

use csv::ByteRecord;

use super::error::{Place, Problem, Row};
use super::guard::{Guard, recover};
use super::head::head;
use super::header::{names, numbered, text};
use super::labview::Clock;
use super::number::{Decimals, trimmed};
use super::room::{check_name, short};
use super::spaces::Spaces;
use super::stamp::Stamps;
use super::units;
use super::utf16::Utf8;
use super::{Column, Limits, RecordingError};

const BUFFER_BYTES: usize = 64 << 10;

type Text<R> = Spaces<Chain<Cursor<Vec<u8>>, BufReader<Guard<Utf8<R>>>>>;

pub(super) struct Rows<'a, R> {
    source: &'a str,
    lines_before: u64,
    reader: csv::Reader<Text<R>>,
    record: ByteRecord,
    has_percent: bool,
    may_be_wider: bool,
    units: Vec<String>,
    clock: Option<Clock>,
    decimals: Decimals,
    stamps: Stamps,
    is_open: Arc<AtomicBool>,
}

impl<'a, R: Read> Rows<'a, R> {
    /// `locate` finds the requested columns. Without a header, columns are named by their numbers.
    pub(super) fn open<T>(
        source: &'a str,
        reader: R,
        limits: &Limits,
        locate: impl FnOnce(&[String]) -> Result<T, Problem>,
    ) -> Result<(Self, T), RecordingError> {
        let guard = Guard::new(source, Utf8::new(reader), limits.max_bytes);
        let is_open = guard.is_open();
        let mut text = BufReader::with_capacity(BUFFER_BYTES, guard);
        let head = head(&mut text, limits.skip_lines).map_err(|error| recover(source, error))?;
        if head.is_incomplete {
            return Err(Place::file(source).error(Problem::LabViewHeader));
        }
        let mut rows = Self {
            source,
            lines_before: head.lines_before,
            reader: csv::ReaderBuilder::new()
                .delimiter(head.separator)
                .has_headers(false)
                .flexible(true)
                .comment(Some(b'#'))
                .buffer_capacity(BUFFER_BYTES)
                .from_reader(Spaces::new(Cursor::new(head.text).chain(text), head.in_spaces)),
            record: ByteRecord::new(),
            has_percent: head.has_percent,
            may_be_wider: head.is_labview,
            units: head.units,
            clock: head.clock,
            decimals: Decimals::new(head.separator),
            stamps: Stamps::default(),
            is_open,
        };
        let names = match head.unnamed {
            Some(width) => Ok(numbered(width)),
            None if !rows.advance()? => return Err(Place::file(source).error(Problem::Empty)),
            None => names(rows.record.iter()),
        };
        let short = |names: Vec<String>| check_names(&names).map(|()| names);
        let located = names.and_then(short).and_then(|names| locate(&names)).map_err(|problem| match problem {
            Problem::NotUtf8 | Problem::NoHeader => rows.place().error(problem),
            Problem::MissingColumn { name, quantity: Some(quantity), available, .. } if head.unnamed.is_some() => {
                Place::file(source).error(Problem::UnnamedColumns { name, quantity, count: available.len() })
            }
            Problem::MissingColumn { .. } if head.unnamed.is_some() => {
                Place::file(source).at_line(head.lines_before + 1).error(Problem::NoHeader)
            }
            _ => Place::file(source).error(problem),
        })?;
        Ok((rows, located))
    }

    fn advance(&mut self) -> Result<bool, RecordingError> {
        let advanced = self.reader.read_byte_record(&mut self.record);
        advanced.map_err(|error| recover(self.source, error.into()))
    }

    pub(super) fn next(&mut self) -> Result<bool, RecordingError> {
        while self.advance()? {
            if !self.is_blank() {
                return Ok(true);
            }
        }
        Ok(false)
    }

    fn is_blank(&self) -> bool {
        let text = self.record.as_slice();
        let content = text.trim_ascii_start();
        content.is_empty()
            || (content.len() < text.len() && content.starts_with(b"#"))
            || (self.has_percent && content.starts_with(b"%"))
    }

    fn spans_lines(&self) -> bool {
        self.record.as_slice().contains(&b'\n')
    }

    /// The reader's position is before the preceding comments and blank lines, so the line is computed from the number
    /// of consumed lines.
    pub(super) fn line(&self) -> u64 {
        let text = self.record.as_slice();
        let inside = text.iter().filter(|&&byte| byte == b'\n').count() as u64;
        // An open quote includes the last line end of the file.
        let own = u64::from(!text.ends_with(b"\n"));
        (self.lines_before + self.reader.position().line()).saturating_sub(inside + own)
    }

    pub(super) fn place(&self) -> Place {
        Place::file(self.source).at_line(self.line())
    }

    pub(super) fn number(&self, index: usize, column: &Column) -> Result<f64, RecordingError> {
        let number = self.parse(index, column.scale()).map(|number| column.shift(number));
        number.map_err(|problem| self.place().in_column(column.name()).error(problem))
    }

    pub(super) fn parse(&self, index: usize, scale: f64) -> Result<f64, Problem> {
        self.decimals.number(self.record.get(index).unwrap_or_default(), scale)
    }

    /// Takes the row if it contains a known unit and no number.
    pub(super) fn take_units(&mut self) -> bool {
        let fields: Vec<String> = self.record.iter().map(|field| short(&text(field))).collect();
        let has_number = (0..fields.len()).any(|index| self.parse(index, 1.0).is_ok());
        if has_number || !fields.iter().any(|field| units::is_known(field)) {
            return false;
        }
        self.units = fields;
        true
    }

    pub(super) fn unfinished(&self, line: u64) -> Option<String> {
        let has_no_end = self.is_open.load(Relaxed);
        has_no_end.then(|| format!("its last line, {line}, has no line end, so that its last number can be incomplete"))
    }

    pub(super) fn unit(&self, index: usize) -> Option<&str> {
        let unit = self.units.get(index)?.trim().trim_matches(['[', ']', '(', ')']);
        (!unit.is_empty()).then_some(unit)
    }

    pub(super) fn clock(&self) -> Option<Clock> {
        self.clock
    }

    pub(super) fn time(
        &mut self,
        index: usize,
        column: &Column,
        before: Option<(f64, u64)>,
    ) -> Result<f64, RecordingError> {
        let number = self.parse(index, 1.0);
        let field = self.record.get(index).unwrap_or_default();
        let time_s = self.stamps.time_s(field, number, column.scale());
        let time_s = column.shift(time_s.map_err(|problem| self.place().in_column(column.name()).error(problem))?);
        match before {
            Some((before_s, before_line)) if time_s <= before_s => {
                let place = self.place().in_column(column.name());
                Err(place.error(not_increasing(Row::Line(before_line), before_s, time_s)))
            }
            _ => Ok(time_s),
        }
    }

    pub(super) fn number_or_date(&self, index: usize, stamps: &mut Stamps) -> Option<f64> {
        let field = self.record.get(index).unwrap_or_default();
        // A fast test: numbers begin with a letter only as "nan" and "inf".
        if field.first().is_some_and(|first| first.is_ascii_alphabetic() && !b"nNiI".contains(first)) {
            return None;
        }
        match self.parse(index, 1.0) {
            Ok(number) => Some(number),
            Err(problem) => stamps.time_s(field, Err(problem), 1.0).ok(),
        }
    }

    pub(super) fn has_dates(&self) -> bool {
        self.stamps.has_dates()
    }

    pub(super) fn origin_s(&self, column: &Column) -> f64 {
        self.stamps.origin_s(column.scale())
    }

    pub(super) fn is_empty_or(&self, index: usize, words: &[&str]) -> bool {
        let text = str::from_utf8(self.record.get(index).unwrap_or_default()).map(trimmed);
        text.is_ok_and(|text| text.is_empty() || words.contains(&text))
    }

    pub(super) fn word(&self, index: usize, column: &Column) -> Result<String, RecordingError> {
        let refuse = |problem| Err(self.place().in_column(column.name()).error(problem));
        match str::from_utf8(self.record.get(index).unwrap_or_default()).map(trimmed) {
            Ok("") => refuse(Problem::EmptyField),
            Ok(text) => Ok(text.to_owned()),
            Err(_) => refuse(Problem::NotUtf8),
        }
    }

    pub(super) fn check_room(&self, kept: usize, limit: usize) -> Result<(), RecordingError> {
        if kept < limit { Ok(()) } else { Err(self.place().error(Problem::TooManySamples { limit })) }
    }

    pub(super) fn check_width(&self, expected: usize) -> Result<(), RecordingError> {
        let found = self.record.len();
        let surplus_is_blank = || self.record.iter().skip(expected).all(|field| field.trim_ascii().is_empty());
        if found == expected || (found > expected && (self.may_be_wider || surplus_is_blank())) {
            Ok(())
        } else if self.spans_lines() {
            Err(self.place().error(Problem::OpenQuote))
        } else {
            Err(self.place().error(Problem::RaggedRow { found, expected }))
        }
    }
}

fn check_names(names: &[String]) -> Result<(), Problem> {
    names.iter().try_for_each(|name| check_name(name.len()))
}

pub(super) fn not_increasing(before: Row, before_s: f64, after_s: f64) -> Problem {
    if after_s == before_s {
        let time_s = after_s;
        Problem::TimeRepeats { before, time_s }
    } else {
        Problem::TimeBackwards { before, before_s, after_s }
    }
}
