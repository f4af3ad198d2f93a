//! Reads samples from CSV text.

use std::io::Read;

use super::error::{Place, Problem};
use super::header::Layout;
use super::table::Rows;
use super::{Columns, Limits, Recording, RecordingError};

/// Reads a recording from CSV text in UTF-8; `source` is its name in messages.
///
/// The first line is the header, which must have each requested name exactly once. The separator is the most frequent
/// of `,`, `;` and tab in the header. Lines that begin with `#`, blank lines (also of separators only), a byte order
/// mark, any kind of line end, quotes, and spaces around names and numbers are allowed. Numbers have a decimal point
/// and may have an exponent. Other columns may hold anything.
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
    while rows.next()? {
        samples.push(&rows, &layout)?;
    }
    samples.finish(source)
}

/// The samples read so far.
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
        let time_s = rows.time(layout.time, &self.columns.time, before)?;
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
        // The limit itself is allowed, up to the rounding of decimal times; a limit of NaN allows nothing.
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

/// The line of each row. Most rows are on consecutive lines, so only the start of each run of lines is kept.
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
