//! Reads samples from CSV text.

use std::io::Read;

use super::error::{Place, Problem, Row};
use super::header::Layout;
use super::labview::X_VALUE;
use super::signals::{Signal, Statistics};
use super::table::Rows;
use super::{Columns, Limits, Recording, RecordingError};

/// Reads a recording from CSV text in UTF-8; `source` is its name in messages.
///
/// The first line is the header, which must contain each requested name exactly once. The separator is the most
/// frequent of `,`, `;` and tab in the header; without any of them it is `|`, or spaces. Comment lines that begin with
/// `#`, blank lines (also with separators), a byte order mark, any kind of line end, quotes, and spaces around names
/// and numbers are allowed. Numbers have a decimal point and may have an exponent. Other columns may contain anything.
///
/// Typical files of laboratories are also accepted:
///
/// - UTF-16 with a byte order mark, and names in Latin-1;
/// - `%` before comments, and names in the comment above the numbers;
/// - a row of units below the names, or in the comment;
/// - decimal commas, unless the comma is the separator or the file also has decimal points;
/// - the header of LabVIEW's `.lvm`, whose `Delta_X` gives the times if `X_Value` is empty.
///
/// # Errors
/// A [`RecordingError`] with the place and the remedy if the text is not such a table; if a requested number is
/// missing, malformed or not finite after scaling; if time does not increase strictly or has a gap above
/// [`Limits::max_gap_s`]; if there are fewer than two samples, or more text or samples than the limits allow.
pub fn read_csv<R: Read>(
    source: &str,
    reader: R,
    columns: &Columns,
    limits: &Limits,
) -> Result<Recording, RecordingError> {
    let (mut rows, layout) =
        Rows::open(source, reader, limits.max_bytes, |header| Layout::locate(header.iter(), columns))?;
    let mut samples = Samples::new(columns, limits);
    let mut has_row = rows.next()?;
    if has_row && rows.take_units() {
        has_row = rows.next()?;
    }
    while has_row {
        samples.push(&rows, &layout)?;
        has_row = rows.next()?;
    }
    samples.finish(source)
}

pub(super) fn names_csv<R: Read>(source: &str, reader: R, limits: &Limits) -> Result<Vec<String>, RecordingError> {
    Rows::open(source, reader, limits.max_bytes, |header| super::header::names(header.iter())).map(|(_, names)| names)
}

/// Lists the columns of a table that contain a number, as signals. Other fields count as undefined.
///
/// # Errors
/// As [`read_csv`], for a text that is not a table.
pub fn scan_csv<R: Read>(source: &str, reader: R, limits: &Limits) -> Result<Vec<Signal>, RecordingError> {
    let (mut rows, names) = Rows::open(source, reader, limits.max_bytes, |header| super::header::names(header.iter()))?;
    let mut statistics = vec![Statistics::default(); names.len()];
    let mut has_row = rows.next()?;
    if has_row && rows.take_units() {
        has_row = rows.next()?;
    }
    let clock = rows.clock();
    let mut count = 0;
    while has_row {
        rows.check_room(count, limits.max_samples)?;
        for (index, statistics) in statistics.iter_mut().enumerate() {
            let value = match clock {
                Some(clock) if names[index] == X_VALUE && rows.is_empty_or(index, &[]) => clock.time_s(count),
                _ => rows.parse(index, 1.0).unwrap_or(f64::NAN),
            };
            statistics.push(value);
        }
        count += 1;
        has_row = rows.next()?;
    }
    let units: Vec<Option<String>> = (0..names.len()).map(|index| rows.unit(index).map(str::to_owned)).collect();
    let columns = names.into_iter().zip(units).zip(statistics).filter(|(_, statistics)| statistics.has_number());
    Ok(columns.map(|((name, unit), statistics)| Signal::new(name, None, unit, vec![count], statistics)).collect())
}

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
        rows.check_room(self.time_s.len(), self.limits.max_samples)?;
        rows.check_width(layout.width)?;
        let before = self.time_s.last().map(|&before_s| (before_s, self.lines.of(self.time_s.len() - 1)));
        let time_s = match rows.clock() {
            Some(clock) if self.columns.time.name() == X_VALUE && rows.is_empty_or(layout.time, &[]) => {
                clock.time_s(self.time_s.len()) * self.columns.time.scale()
            }
            _ => rows.time(layout.time, &self.columns.time, before)?,
        };
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
        check_gaps(source, recording, self.columns, self.limits, |row| Row::Line(self.lines.of(row)))
    }
}

/// Checks that no gap exceeds the limit, and returns the recording. `row` gives the place of a sample.
pub(super) fn check_gaps(
    source: &str,
    recording: Recording,
    columns: &Columns,
    limits: &Limits,
    row: impl Fn(usize) -> Row,
) -> Result<Recording, RecordingError> {
    let median_s = recording.median_interval_s();
    let limit_s = limits.max_gap_s.unwrap_or(Limits::GAP_IN_MEDIANS * median_s);
    let mut pairs = recording.time_s().windows(2);
    // Gaps equal to the limit are allowed, up to the rounding of decimal times; a limit of NaN allows no gap.
    let allowed = |gap_s: f64| gap_s <= limit_s * (1.0 + 1e-9);
    let Some(before) = pairs.position(|pair| !allowed(pair[1] - pair[0])) else {
        return Ok(recording);
    };
    let place = Place::file(source).at(row(before + 1));
    Err(place.in_column(columns.time.name()).error(Problem::Gap {
        before: row(before),
        before_s: recording.time_s()[before],
        after_s: recording.time_s()[before + 1],
        limit_s,
        median_s: limits.max_gap_s.is_none().then_some(median_s),
    }))
}

/// The line of each row. Most rows are on consecutive lines, so only the start of each run of lines is stored.
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
