use std::io::{BufRead, BufReader, Read};

use super::json::JsonColumns;
use super::topics::Refusal;
use super::{Array, Format, Loaded};
use crate::RecordingError;
use crate::error::{Place, Problem};
use crate::guard::{Guard, recover};
use crate::room::Room;

pub(crate) fn open(source: &str, reader: impl Read, room: &Room) -> Result<Loaded, RecordingError> {
    let limits = room.limits();
    let mut text = BufReader::new(Guard::new(source, reader, limits.max_bytes));
    let (mut objects, mut lines, mut line) = (JsonColumns::default(), vec![], vec![]);
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
        room.take_values(1 + objects.names.len()).map_err(|problem| place().error(problem))?;
        objects.push(object, room).map_err(|refusal| match refusal {
            Refusal::Message(reason) => place().error(Format::JsonLines.damaged(reason)),
            Refusal::File(problem) => place().error(problem),
        })?;
        lines.push(number);
    }
    let rows = lines.len();
    let (mut arrays, mut columns) = (vec![], vec![]);
    for (name, column, has_dates) in objects.finish() {
        let array = Array::in_room(&name, vec![rows], room).map_err(|problem| Place::file(source).error(problem))?;
        arrays.push(Array { unit: has_dates.then(|| "s".to_owned()), ..array });
        columns.push(column);
    }
    let loaded = Loaded::new(Format::JsonLines, arrays, columns, &[]);
    Ok(loaded.map_err(|problem| Place::file(source).error(problem))?.with_lines(lines))
}
