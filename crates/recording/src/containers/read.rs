//! Creates a recording or a list of the signals of a container.

use super::name::{Vector, find, vectors};
use super::{Container, Fault};
use crate::error::{Place, Problem, Row};
use crate::read::check_gaps;
use crate::signals::{Signal, Statistics};
use crate::table::not_increasing;
use crate::{Column, Columns, Limits, Quantity, Recording, RecordingError};

/// Reads a recording of the signals that `columns` names.
pub(crate) fn read(
    file: &str,
    container: &mut dyn Container,
    columns: &Columns,
    limits: &Limits,
) -> Result<Recording, RecordingError> {
    let requested = [
        (Quantity::Time, Some(&columns.time)),
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
    for (_, column, vector) in &found {
        if vector.len != times {
            let fitting =
                vectors(container.arrays()).into_iter().filter(|other| other.len == times).map(|other| other.name);
            let problem = Problem::Lengths {
                samples: vector.len,
                times,
                time: columns.time.name().into(),
                fitting: fitting.collect(),
            };
            return Err(Place::file(file).in_column(column.name()).error(problem));
        }
    }
    if times < 2 {
        return Err(Place::file(file).error(Problem::TooFewSamples(times)));
    }
    if times > limits.max_samples {
        return Err(Place::file(file).error(Problem::TooManySamples { limit: limits.max_samples }));
    }
    let mut signals = [const { None }; Quantity::ALL.len()];
    for (quantity, column, vector) in &found {
        signals[*quantity as usize] = Some(values(file, container, column, vector)?);
    }
    let [Some(time_s), Some(position_m), velocity_m_per_s, Some(force_n)] = signals else {
        return Err(Place::file(file).error(Problem::TooFewSamples(0)));
    };
    let time = &found[0].2;
    let row = |sample: usize| container.row(time.array, sample);
    if let Some(before) = time_s.windows(2).position(|pair| pair[1] <= pair[0]) {
        let place = Place::file(file).at(row(before + 1)).in_column(columns.time.name());
        return Err(place.error(not_increasing(row(before), time_s[before], time_s[before + 1])));
    }
    let recording = Recording::from_checked(time_s, position_m, velocity_m_per_s, force_n);
    check_gaps(file, recording, columns, limits, row)
}

/// Reads the samples of a signal in SI units, and checks that they are finite.
fn values(
    file: &str,
    container: &mut dyn Container,
    column: &Column,
    vector: &Vector,
) -> Result<Vec<f64>, RecordingError> {
    let place = || Place::file(file).in_column(column.name());
    let refuse = |row: Option<Row>, problem| row.map_or(place(), |row| place().at(row)).error(problem);
    let whole = container.values(vector.array).map_err(|Fault { row, problem }| refuse(row, problem))?;
    let mut values: Vec<f64> = Vec::with_capacity(vector.len);
    for (sample, value) in vector.of(&whole).enumerate() {
        let scaled = value * column.scale();
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

/// An array with less than this share of the longest signal's samples is a setting, such as the style of a plot.
const MIN_SHARE: f64 = 0.01;

/// Lists the signals of a container, without unreadable arrays and arrays below [`MIN_SHARE`].
pub(crate) fn scan(container: &mut dyn Container) -> Vec<Signal> {
    let mut vectors = vectors(container.arrays());
    let longest = vectors.iter().map(|vector| vector.len).max().unwrap_or(0);
    vectors.retain(|vector| vector.len as f64 >= MIN_SHARE * longest as f64);
    let mut signals = vec![];
    let mut whole: Option<(usize, Vec<f64>)> = None;
    for vector in vectors {
        if whole.as_ref().is_none_or(|(array, _)| *array != vector.array) {
            whole = container.values(vector.array).ok().map(|values| (vector.array, values));
        }
        let Some((_, values)) = &whole else { continue };
        let mut statistics = Statistics::default();
        vector.of(values).for_each(|value| statistics.push(value));
        let array = &container.arrays()[vector.array];
        let shape = if array.dims.len() == 1 { vec![vector.len] } else { array.dims.clone() };
        let (label, unit) = (array.label.clone(), array.unit.clone());
        signals.push(Signal::new(vector.name, label, unit, shape, statistics));
    }
    signals
}
