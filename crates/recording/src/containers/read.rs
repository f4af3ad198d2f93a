use super::join::{Clock, Timed, join, other_clock};
use super::name::{Vector, find, vectors};
use super::{Container, Fault};
use crate::error::{Place, Problem, Row};
use crate::read::{check_gaps, check_times};
use crate::room::Room;
use crate::samples::intervals;
use crate::signals::{Signal, Statistics};
use crate::stamp::CALENDAR_S;
use crate::table::not_increasing;
use crate::{Column, Columns, IgnoredUnit, Quantity, Recording, RecordingError};

pub(crate) fn read(
    file: &str,
    container: &mut dyn Container,
    columns: &Columns,
    room: &Room,
) -> Result<Recording, RecordingError> {
    let limits = room.limits();
    let requested = [
        (Quantity::Time, Some(&columns.time).filter(|_| limits.rate_hz.is_none())),
        (Quantity::Position, Some(&columns.position)),
        (Quantity::Velocity, columns.velocity.as_ref()),
        (Quantity::Force, Some(&columns.force)),
    ];
    let mut found = vec![];
    for (quantity, column) in requested {
        let Some(column) = column else { continue };
        let vector =
            find(container.arrays(), column.name(), quantity).map_err(|problem| Place::file(file).error(problem))?;
        found.push((quantity, column, vector));
    }
    let times = found[0].2.len;
    let arrays = container.arrays();
    let has_time = limits.rate_hz.is_none();
    let clocks: Vec<Option<Clock>> = found
        .iter()
        .map(|(_, _, vector)| if has_time { other_clock(arrays, &found[0].2, vector) } else { None })
        .collect();
    for ((_, column, vector), clock) in found.iter().zip(&clocks) {
        let problem = match clock {
            Some(Clock::Times(_)) => continue,
            Some(Clock::NotShared(shared)) => {
                Problem::Clocks { time: columns.time.name().into(), shared: shared.as_str().into() }
            }
            None if vector.len == times => continue,
            None => {
                let fitting = vectors(arrays).into_iter().filter(|other| other.len == times).map(|other| other.name);
                let time = columns.time.name().into();
                Problem::Lengths { samples: vector.len, times, time, fitting: fitting.collect() }
            }
        };
        return Err(Place::file(file).in_column(column.name()).error(problem));
    }
    if times < 2 {
        return Err(Place::file(file).error(Problem::TooFewSamples(times)));
    }
    if times > limits.max_samples {
        return Err(Place::file(file).error(Problem::TooManySamples { limit: limits.max_samples }));
    }
    let mut signals = [const { None }; Quantity::ALL.len()];
    for (quantity, column, vector) in &found {
        signals[*quantity as usize] = Some(values(file, container, column, vector, room)?);
    }
    if let Some(rate_hz) = limits.rate_hz {
        signals[Quantity::Time as usize] = Some((0..times).map(|sample| sample as f64 / rate_hz).collect());
    }
    let time = &found[0].2;
    let mut reports = vec![];
    if clocks.iter().any(Option::is_some) {
        let mut timed = vec![];
        for ((quantity, column, vector), clock) in found.iter().zip(&clocks) {
            let of_clock = match clock {
                Some(Clock::Times(index)) => Vector::whole(*index, &container.arrays()[*index]),
                _ => time.clone(),
            };
            let time_s = values(file, container, &columns.time, &of_clock, room)?;
            let row = |sample: usize| container.row(of_clock.array, sample);
            let of_clock = Column::new(&of_clock.name, 1.0).unwrap_or_else(|_| columns.time.clone());
            check_order(file, &of_clock, &time_s, row)?;
            let [_, median_s, _] = intervals(&time_s);
            check_times(file, &of_clock, limits, (&time_s, median_s), row)?;
            let name = column.name().to_owned();
            timed.push(Timed { name, time_s, values: signals[*quantity as usize].take().unwrap_or_default() });
            debug_assert_eq!(vector.len, timed.last().map_or(0, |signal| signal.values.len()));
        }
        // The time itself is a signal of its own clock only.
        let of_time = timed.remove(0);
        let Some((time_s, joined, all)) = join(&timed) else {
            let (time, shared) = (columns.time.name().into(), of_time.name.into());
            return Err(Place::file(file).error(Problem::NoCommonTime { time, shared }));
        };
        reports = all;
        signals[Quantity::Time as usize] = Some(time_s);
        for ((quantity, ..), values) in found.iter().skip(1).zip(joined) {
            signals[*quantity as usize] = Some(values);
        }
    }
    let [Some(mut time_s), Some(mut position_m), mut velocity_m_per_s, Some(mut force_n)] = signals else {
        return Err(Place::file(file).error(Problem::TooFewSamples(0)));
    };
    // Some programs write the first time twice. The last row counts.
    let repeated = time_s.iter().take_while(|other| **other == time_s[0]).count() - 1;
    for column in [Some(&mut time_s), Some(&mut position_m), velocity_m_per_s.as_mut(), Some(&mut force_n)] {
        column.into_iter().for_each(|column| drop(column.drain(..repeated)));
    }
    let origin_s = since_first(&mut time_s);
    if time_s.len() < 2 {
        return Err(Place::file(file).error(Problem::TooFewSamples(time_s.len())));
    }
    let row = |sample: usize| container.row(time.array, sample + repeated);
    check_order(file, &columns.time, &time_s, row)?;
    let recording = Recording::from_checked(time_s, position_m, velocity_m_per_s, force_n);
    let unit = |vector: &Vector| container.arrays()[vector.array].unit.as_deref();
    let ignored =
        found.iter().filter_map(|(quantity, column, vector)| IgnoredUnit::of(*quantity, column, unit(vector)));
    let recording = recording.since(origin_s).with_joined(reports).with_ignored_units(ignored.collect());
    let recording = recording.with_unfinished(container.unfinished().map(str::to_owned));
    check_gaps(file, recording, columns, limits, row)
}

fn check_order(file: &str, column: &Column, time_s: &[f64], row: impl Fn(usize) -> Row) -> Result<(), RecordingError> {
    let Some(before) = time_s.windows(2).position(|pair| pair[1] <= pair[0]) else { return Ok(()) };
    let place = Place::file(file).at(row(before + 1)).in_column(column.name());
    Err(place.error(not_increasing(row(before), time_s[before], time_s[before + 1])))
}

/// Returns the first time of the calendar, in s since 1970; 0 for other times.
fn since_first(time_s: &mut [f64]) -> f64 {
    let origin_s = time_s.first().copied().filter(|first_s| first_s.abs() >= CALENDAR_S).unwrap_or(0.0);
    time_s.iter_mut().for_each(|time_s| *time_s -= origin_s);
    origin_s
}

fn values(
    file: &str,
    container: &mut dyn Container,
    column: &Column,
    vector: &Vector,
    room: &Room,
) -> Result<Vec<f64>, RecordingError> {
    let place = || Place::file(file).in_column(column.name());
    let refuse = |row: Option<Row>, problem| row.map_or(place(), |row| place().at(row)).error(problem);
    let count = container.arrays()[vector.array].len();
    room.take_values(count).map_err(|problem| refuse(None, problem))?;
    let whole = container.values(vector.array, room).map_err(|Fault { row, problem }| refuse(row, problem))?;
    let mut values: Vec<f64> = Vec::with_capacity(vector.len);
    for (sample, value) in vector.of(&whole).enumerate() {
        let scaled = column.convert(value);
        if !scaled.is_finite() {
            let problem = match value {
                value if value.is_nan() => Problem::Undefined,
                value => Problem::NotFinite { text: value.to_string().into(), scale: column.scale() },
            };
            return Err(refuse(Some(container.row(vector.array, sample)), problem));
        }
        values.push(scaled);
    }
    Ok(values)
}

/// An array with a smaller share of the longest signal's samples is a setting, such as the style of a plot.
const MIN_SHARE: f64 = 0.01;

/// If no array is readable, the error is that of the first one.
pub(crate) fn scan(file: &str, container: &mut dyn Container, room: &Room) -> Result<Vec<Signal>, RecordingError> {
    let mut vectors = vectors(container.arrays());
    let longest = vectors.iter().map(|vector| vector.len).max().unwrap_or(0);
    vectors.retain(|vector| vector.len as f64 >= MIN_SHARE * longest as f64);
    let mut signals = vec![];
    let mut whole: Option<(usize, Vec<f64>)> = None;
    let mut failure = None;
    for vector in vectors {
        if whole.as_ref().is_none_or(|(array, _)| *array != vector.array) {
            room.take_values(container.arrays()[vector.array].len())
                .map_err(|problem| Place::file(file).error(problem))?;
            whole = match container.values(vector.array, room) {
                Ok(values) => Some((vector.array, values)),
                Err(Fault { problem: problem @ Problem::TooManyBytes { .. }, .. }) => {
                    return Err(Place::file(file).error(problem));
                }
                Err(fault) => {
                    failure.get_or_insert((vector.name.clone(), fault));
                    None
                }
            };
        }
        let Some((_, values)) = &whole else { continue };
        let mut statistics = Statistics::default();
        vector.of(values).for_each(|value| statistics.push(value));
        let array = &container.arrays()[vector.array];
        let shape = if array.dims.len() == 1 { vec![vector.len] } else { array.dims.clone() };
        let (label, unit) = (array.label.clone(), array.unit.clone());
        signals.push(Signal::new(vector.name, label, unit, shape, statistics));
    }
    match failure {
        Some((name, fault)) if signals.is_empty() => Err(Place::file(file).in_column(&name).error(fault.problem)),
        _ => Ok(signals),
    }
}
