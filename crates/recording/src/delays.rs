use std::io::Read;

use super::error::{Place, Problem};
use super::header::find;
use super::table::Rows;
use super::{Column, Limits, RecordingError};

/// Equivalent to an empty field.
const LOST: &str = "lost";

/// Valid from its time onwards.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DelayRow {
    pub time_s: f64,
    /// `None` for a lost sample; master to slave.
    pub forward_s: Option<f64>,
    /// `None` for a lost sample; slave to master.
    pub backward_s: Option<f64>,
}

/// Passes the rows of CSV text with the columns `time_s`, `forward_delay_s` and `backward_delay_s` to `take`. An empty
/// delay or the word `lost` means a lost sample.
pub fn read_delays<R: Read>(
    source: &str,
    reader: R,
    limits: &Limits,
    max_s: f64,
    mut take: impl FnMut(&DelayRow),
) -> Result<(), RecordingError> {
    let columns = ["time_s", "forward_delay_s", "backward_delay_s"].map(Column::plain);
    let (mut rows, (at, width)) = Rows::open(source, reader, &limits.of_table(), |names| {
        let [time, forward, backward] = &columns;
        Ok(([find(names, time)?, find(names, forward)?, find(names, backward)?], names.len()))
    })?;
    let mut before = None;
    let mut count = 0;
    while rows.next()? {
        rows.check_room(count, limits.max_samples)?;
        rows.check_width(width)?;
        let time_s = rows.time(at[0], &columns[0], before)?;
        let delay = |direction: usize| {
            let (index, column) = (at[direction], &columns[direction]);
            if rows.is_empty_or(index, &[LOST]) {
                return Ok(None);
            }
            let delay_s = rows.number(index, column)?;
            if (0.0..=max_s).contains(&delay_s) {
                return Ok(Some(delay_s));
            }
            Err(rows.place().in_column(column.name()).error(Problem::DelayOutOfRange { delay_s, max_s }))
        };
        take(&DelayRow { time_s, forward_s: delay(1)?, backward_s: delay(2)? });
        before = Some((time_s, rows.line()));
        count += 1;
    }
    if count < 2 {
        return Err(Place::file(source).error(Problem::TooFewSamples(count)));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(table: impl AsRef<[u8]>) -> Result<Vec<DelayRow>, RecordingError> {
        let mut rows = vec![];
        read_delays("wifi.csv", table.as_ref(), &Limits::default(), 1.0, |row| rows.push(*row)).map(|()| rows)
    }

    fn refusal(rows: &str) -> String {
        read(format!("time_s,forward_delay_s,backward_delay_s\n{rows}")).expect_err("refused").to_string()
    }

    #[test]
    fn rows_are_passed_on_with_lost_samples_marked() {
        let table =
            "# by hand\nbackward_delay_s;note;time_s;forward_delay_s\n0.02;x;-1;0.01\n;;0.5;lost\n\n \"lost\" ;y;2; \n";
        let row = |time_s, forward_s, backward_s| DelayRow { time_s, forward_s, backward_s };
        let expected = vec![row(-1.0, Some(0.01), Some(0.02)), row(0.5, None, None), row(2.0, None, None)];
        assert_eq!(read(table).expect("a trace"), expected);
    }

    #[test]
    fn invalid_delays_are_rejected_with_their_place() {
        for (rows, problem) in [
            ("0,0.1,0.1\n1,-0.1,0\n", " line 3, column 'forward_delay_s': a delay of -0.1 s, must be from 0 to 1 s"),
            ("0,0.1,1.5\n", " line 2, column 'backward_delay_s': a delay of 1.5 s, must be from 0 to 1 s"),
            ("0,gone,0\n", " line 2, column 'forward_delay_s': 'gone' is not a number"),
            ("0,0,NaN\n", " line 2, column 'backward_delay_s': 'NaN' is not finite"),
            (",0,0\n", " line 2, column 'time_s': the field is empty"),
            ("lost,0,0\n", " line 2, column 'time_s': 'lost' is not a number"),
            ("0,0,0\n1,0,0\n0.5,0,0\n", " line 4, column 'time_s': time decreases, from 1 s on line 3 to 0.5 s"),
            ("0,0,0\n0,0,0\n", " line 3, column 'time_s': the time 0 s repeats that of line 2"),
            ("0,0\n", " line 2: the row has 2 fields, the header 3"),
        ] {
            assert_eq!(refusal(rows).split(';').next(), Some(&*format!("wifi.csv{problem}")));
        }
    }

    #[test]
    fn files_that_are_no_trace_are_rejected() {
        assert_eq!(refusal("0,0,0\n"), "wifi.csv: holds a single sample; at least two are needed");
        assert_eq!(refusal(""), "wifi.csv: holds a header but no samples; at least two are needed");
        assert!(read("").expect_err("empty").to_string().starts_with("wifi.csv: holds no data"));
        assert!(
            read("0,0,0\n1,0,0\n").expect_err("no header").to_string().starts_with("wifi.csv line 1: numbers where")
        );
        let named = read("time_s,forward_delay,backward_delay_s\n").expect_err("misspelt").to_string();
        assert!(
            named.contains("no column 'forward_delay_s'") && named.contains("did you mean 'forward_delay'?"),
            "{named}"
        );
    }

    #[test]
    fn bytes_and_samples_are_limited() {
        let table = "time_s,forward_delay_s,backward_delay_s\n0,0,0\n1,0,0\n2,0,0\n";
        let limited = |max_bytes, max_samples| {
            let limits = Limits { max_bytes, max_samples, ..Limits::default() };
            read_delays("wifi.csv", table.as_bytes(), &limits, 1.0, |_| ()).map_err(|error| error.to_string())
        };
        assert_eq!(limited(100, 3), Ok(()));
        assert!(limited(100, 2).expect_err("rows").starts_with("wifi.csv line 4: more than 2 samples"));
        assert!(limited(20, 3).expect_err("bytes").starts_with("wifi.csv: holds more than"));
    }
}
