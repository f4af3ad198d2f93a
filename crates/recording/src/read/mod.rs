use std::io::Read;

use super::arrays::first_where;
use super::error::{Place, Problem, Row};
use super::header::Layout;
use super::labview::X_VALUE;
use super::room::Room;
use super::signals::{Signal, Statistics};
use super::stamp::Stamps;
use super::table::Rows;
use super::{Column, Columns, IgnoredUnit, Limits, Quantity, Recording, RecordingError};

/// `source` is its name in messages.
///
/// The header must contain each requested name exactly once. The manual lists the accepted forms of tables (*Read the
/// files of a lab*).
pub fn read_csv<R: Read>(
    source: &str,
    reader: R,
    columns: &Columns,
    limits: &Limits,
) -> Result<Recording, RecordingError> {
    let (mut rows, layout) =
        Rows::open(source, reader, limits, |names| Layout::locate(names, columns, limits.rate_hz.is_some()))?;
    let mut samples = Samples::new(columns, limits);
    let mut has_row = rows.next()?;
    if has_row && rows.take_units() {
        has_row = rows.next()?;
    }
    while has_row {
        samples.push(&mut rows, &layout)?;
        has_row = rows.next()?;
    }
    let last_line = samples.time_s.len().checked_sub(1).map_or(0, |row| samples.lines.of(row));
    let recording = samples.finish(source, rows.origin_s(&columns.time))?;
    let of = |(quantity, column, index): (Quantity, Option<&Column>, Option<usize>)| {
        IgnoredUnit::of(quantity, column?, rows.unit(index?))
    };
    let requested = [
        (Quantity::Time, Some(&columns.time).filter(|_| !rows.has_dates()), layout.time),
        (Quantity::Position, Some(&columns.position), Some(layout.position)),
        (Quantity::Velocity, columns.velocity.as_ref(), layout.velocity),
        (Quantity::Force, Some(&columns.force), Some(layout.force)),
    ];
    let recording = recording.with_unfinished(rows.unfinished(last_line));
    Ok(recording.with_ignored_units(requested.into_iter().filter_map(of).collect()))
}

pub(super) fn names_csv<R: Read>(source: &str, reader: R, limits: &Limits) -> Result<Vec<String>, RecordingError> {
    Rows::open(source, reader, limits, |names| Ok(names.to_vec())).map(|(_, names)| names)
}

/// Lists the columns that contain a number. Other fields count as undefined.
pub fn scan_csv<R: Read>(source: &str, reader: R, limits: &Limits) -> Result<Vec<Signal>, RecordingError> {
    let (mut rows, names) = Rows::open(source, reader, limits, |names| Ok(names.to_vec()))?;
    let room = Room::new(limits);
    let taken = names.iter().try_for_each(|name| room.take_signals(name, 1));
    taken.map_err(|problem| Place::file(source).error(problem))?;
    let mut statistics = vec![(Statistics::default(), Stamps::default()); names.len()];
    let mut has_row = rows.next()?;
    if has_row && rows.take_units() {
        has_row = rows.next()?;
    }
    let clock = rows.clock();
    let mut count = 0;
    while has_row {
        rows.check_room(count, limits.max_samples)?;
        for (index, (statistics, stamps)) in statistics.iter_mut().enumerate() {
            let value = match clock {
                Some(clock) if names[index] == X_VALUE && rows.is_empty_or(index, &[]) => clock.time_s(count),
                _ => rows.number_or_date(index, stamps).unwrap_or(f64::NAN),
            };
            statistics.push(value);
        }
        count += 1;
        has_row = rows.next()?;
    }
    if count == 0 {
        return Err(Place::file(source).error(Problem::TooFewSamples(0)));
    }
    if !statistics.iter().any(|(statistics, _)| statistics.has_number()) {
        return Err(Place::file(source).error(Problem::NoNumbers { names }));
    }
    let units: Vec<Option<String>> = (0..names.len()).map(|index| rows.unit(index).map(str::to_owned)).collect();
    let columns = names.into_iter().zip(units).zip(statistics);
    let columns = columns.filter(|(_, (statistics, _))| statistics.has_number());
    let signal = |((name, unit), (statistics, stamps)): ((String, _), (_, Stamps))| {
        // A date has the unit of the seconds that it is read as.
        let unit = if stamps.has_dates() { Some("s".to_owned()) } else { unit };
        Signal::new(name, None, unit, vec![count], statistics)
    };
    Ok(columns.map(signal).collect())
}

struct Samples<'a> {
    columns: &'a Columns,
    limits: &'a Limits,
    time_s: Vec<f64>,
    position_m: Vec<f64>,
    velocity_m_per_s: Vec<f64>,
    force_n: Vec<f64>,
    lines: Lines,
    /// With the rows that repeat the first time.
    rows: usize,
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
            rows: 0,
        }
    }

    fn push<R: Read>(&mut self, rows: &mut Rows<'_, R>, layout: &Layout) -> Result<(), RecordingError> {
        rows.check_room(self.rows, self.limits.max_samples)?;
        rows.check_width(layout.width)?;
        let time_s = self.time_s(rows, layout)?;
        // Some programs write the first time twice. The last row counts.
        if self.time_s == [time_s] {
            *self = Self { rows: self.rows, ..Self::new(self.columns, self.limits) };
        }
        self.rows += 1;
        self.position_m.push(rows.number(layout.position, &self.columns.position)?);
        if let (Some(index), Some(column)) = (layout.velocity, &self.columns.velocity) {
            self.velocity_m_per_s.push(rows.number(index, column)?);
        }
        self.force_n.push(rows.number(layout.force, &self.columns.force)?);
        self.lines.push(self.time_s.len(), rows.line());
        self.time_s.push(time_s);
        Ok(())
    }

    fn time_s<R: Read>(&self, rows: &mut Rows<'_, R>, layout: &Layout) -> Result<f64, RecordingError> {
        let (sample, column) = (self.time_s.len(), &self.columns.time);
        let Some(index) = layout.time else {
            return Ok(sample as f64 / self.limits.rate_hz.unwrap_or(1.0));
        };
        match rows.clock() {
            Some(clock) if column.name() == X_VALUE && rows.is_empty_or(index, &[]) => {
                Ok(column.convert(clock.time_s(sample)))
            }
            _ => {
                let before = self.time_s.last().map(|&before_s| (before_s, self.lines.of(sample - 1)));
                match rows.time(index, column, before) {
                    Err(RecordingError { problem: Problem::TimeRepeats { time_s, .. }, .. }) if sample == 1 => {
                        Ok(time_s)
                    }
                    time_s => time_s,
                }
            }
        }
    }

    fn finish(self, source: &str, origin_s: f64) -> Result<Recording, RecordingError> {
        if self.time_s.len() < 2 {
            return Err(Place::file(source).error(Problem::TooFewSamples(self.time_s.len())));
        }
        let velocity = self.columns.velocity.as_ref().map(|_| self.velocity_m_per_s);
        let recording = Recording::from_checked(self.time_s, self.position_m, velocity, self.force_n);
        let recording = recording.since(origin_s);
        check_gaps(source, recording, self.columns, self.limits, |row| Row::Line(self.lines.of(row)))
    }
}

pub(super) fn check_gaps(
    source: &str,
    recording: Recording,
    columns: &Columns,
    limits: &Limits,
    row: impl Fn(usize) -> Row,
) -> Result<Recording, RecordingError> {
    check_times(source, &columns.time, limits, (recording.time_s(), recording.median_interval_s()), &row)?;
    let signals = [
        (Quantity::Position, Some(&columns.position), recording.position_m()),
        (Quantity::Velocity, columns.velocity.as_ref(), recording.velocity_m_per_s().unwrap_or(&[])),
        (Quantity::Force, Some(&columns.force), recording.force_n()),
    ];
    for (quantity, column, samples) in signals {
        if let (Some(column), Some(sample)) =
            (column, first_where(samples, |value| value.abs() > Limits::MAX_MAGNITUDE))
        {
            let problem = Problem::TooBig { value: samples[sample], quantity };
            return Err(Place::file(source).at(row(sample)).in_column(column.name()).error(problem));
        }
    }
    Ok(recording)
}

pub(super) fn check_times(
    source: &str,
    column: &Column,
    limits: &Limits,
    (time_s, median_s): (&[f64], f64),
    row: impl Fn(usize) -> Row,
) -> Result<(), RecordingError> {
    let limit_s = limits.max_gap_s.unwrap_or(Limits::GAP_IN_MEDIANS * median_s);
    let mut pairs = time_s.windows(2);
    // Up to the rounding of decimal times; a limit of NaN allows no gap.
    let allowed = |gap_s: f64| gap_s <= limit_s * (1.0 + 1e-9);
    let Some(before) = pairs.position(|pair| !allowed(pair[1] - pair[0])) else { return Ok(()) };
    let place = Place::file(source).at(row(before + 1));
    Err(place.in_column(column.name()).error(Problem::Gap {
        before: row(before),
        before_s: time_s[before],
        after_s: time_s[before + 1],
        limit_s,
        median_s: limits.max_gap_s.is_none().then_some(median_s),
    }))
}

/// The start of each run of consecutive lines.
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
