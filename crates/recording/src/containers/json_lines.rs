//! JSON lines: an object per line, with the numbers of a sample.

use std::io::{BufRead, BufReader, Read};

use super::json::JsonColumns;
use super::{Array, Format, Loaded};
use crate::error::{Place, Problem};
use crate::guard::{Guard, recover};
use crate::{Limits, RecordingError};

pub(crate) fn open(source: &str, reader: impl Read, limits: &Limits) -> Result<Loaded, RecordingError> {
    let mut text = BufReader::new(Guard::new(source, reader, limits.max_bytes));
    let (mut objects, mut lines, mut line) = (JsonColumns::default(), vec![], vec![]);
    let mut count = 0;
    for number in 1.. {
        line.clear();
        if text.read_until(b'\n', &mut line).map_err(|error| recover(source, error))? == 0 {
            break;
        }
        if number <= limits.skip_lines || line.trim_ascii().is_empty() {
            continue;
        }
        let place = || Place::file(source).at_line(number);
        if lines.len() >= limits.max_samples {
            return Err(place().error(Problem::TooManySamples { limit: limits.max_samples }));
        }
        let object = line.trim_ascii();
        objects.push(object).map_err(|error| place().error(Format::JsonLines.damaged(error)))?;
        lines.push(number);
        count += 8 * (1 + objects.names.len() as u64);
        if count > limits.max_bytes {
            return Err(place().error(Problem::TooManyBytes { limit: limits.max_bytes }));
        }
    }
    let rows = lines.len();
    let (mut arrays, mut columns) = (vec![], vec![]);
    for (name, column, has_dates) in objects.finish() {
        arrays.push(Array { unit: has_dates.then(|| "s".to_owned()), ..Array::new(name, vec![rows]) });
        columns.push(column);
    }
    let loaded = Loaded::new(Format::JsonLines, arrays, columns, &[]);
    Ok(loaded.map_err(|problem| Place::file(source).error(problem))?.with_lines(lines))
}
