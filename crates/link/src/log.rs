//! Logs of a link, and their comparison with a simulation.

use std::collections::HashMap;
use std::fmt::Write as _;

use thiserror::Error;

use trocar_core::time::{TickGrid, nearest_ticks};
use trocar_engine::channel::Schedule;
use trocar_engine::engine::{COLUMNS, ColumnValues, Trace};

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Direction {
    Forward,
    Backward,
}

impl Direction {
    pub fn column(self) -> &'static str {
        match self {
            Self::Forward => "forward_delay_s",
            Self::Backward => "backward_delay_s",
        }
    }
}

#[derive(Debug, Error)]
pub enum RemoteLogError {
    #[error("{file}: {source}")]
    Table { file: String, source: csv::Error },
    #[error("{file}: there is no column {column}")]
    NoColumn { file: String, column: &'static str },
    #[error("{file} row {row}, column {column}: {field:?} is not a number")]
    NotANumber { file: String, row: usize, column: String, field: String },
    #[error("{file}: {rows} rows, but the scenario has {ticks} ticks: the logs are of another scenario")]
    Ticks { file: String, rows: usize, ticks: u64 },
}

/// Delays of both directions in ticks, by the tick that sent the message, for `channel.delays_file`.
pub fn delays_csv(delays: &[(Direction, &[u32])], grid: &TickGrid) -> String {
    let mut text = "time_s".to_owned();
    for (direction, _) in delays {
        let _ = write!(text, ",{}", direction.column());
    }
    text.push('\n');
    for tick in 0..grid.ticks() {
        let _ = write!(text, "{:?}", grid.time_s(tick));
        for (_, delays) in delays {
            match delays.get(tick as usize).copied().filter(|delay| *delay != Schedule::LOST) {
                Some(delay) => {
                    let _ = write!(text, ",{:?}", grid.time_s(u64::from(delay)));
                }
                None => text.push_str(",lost"),
            }
        }
        text.push('\n');
    }
    text
}

pub fn read_direction(
    file: &str,
    text: &str,
    direction: Direction,
    grid: &TickGrid,
) -> Result<Vec<u32>, RemoteLogError> {
    let mut reader = csv::Reader::from_reader(text.as_bytes());
    let table = |source| RemoteLogError::Table { file: file.to_owned(), source };
    let column = direction.column();
    let place = reader.headers().map_err(table)?.iter().position(|name| name == column);
    let place = place.ok_or(RemoteLogError::NoColumn { file: file.to_owned(), column })?;
    let mut delays = vec![];
    for (row, record) in reader.records().enumerate() {
        let record = record.map_err(table)?;
        let field = record.get(place).unwrap_or_default();
        delays.push(if field == "lost" {
            Schedule::LOST
        } else {
            let delay_s = number(file, (row, column), field)?;
            u32::try_from(nearest_ticks(delay_s, grid.tick_s())).unwrap_or(Schedule::LOST)
        });
    }
    if delays.len() as u64 != grid.ticks() {
        return Err(RemoteLogError::Ticks { file: file.to_owned(), rows: delays.len(), ticks: grid.ticks() });
    }
    Ok(delays)
}

fn number(file: &str, (row, column): (usize, &str), field: &str) -> Result<f64, RemoteLogError> {
    field.parse().map_err(|_| RemoteLogError::NotANumber {
        file: file.to_owned(),
        row: row + 1,
        column: column.to_owned(),
        field: field.to_owned(),
    })
}

#[derive(Debug, Clone, PartialEq)]
pub struct Difference {
    pub tick: u64,
    pub column: String,
    pub logged: f64,
    pub simulated: f64,
}

/// The number of ticks in a log of signals, and the first tick that differs from a simulation in any bit.
pub fn first_difference(file: &str, text: &str, trace: &Trace) -> Result<(u64, Option<Difference>), RemoteLogError> {
    let mut reader = csv::Reader::from_reader(text.as_bytes());
    let table = |source| RemoteLogError::Table { file: file.to_owned(), source };
    let simulated: HashMap<&str, ColumnValues<&[f64], &[u8]>> = COLUMNS.into_iter().zip(trace.columns()).collect();
    let names: Vec<String> = reader.headers().map_err(table)?.iter().map(str::to_owned).collect();
    let mut ticks = 0;
    for (row, record) in reader.records().enumerate() {
        let record = record.map_err(table)?;
        for (name, field) in names.iter().zip(&record) {
            let value = match simulated.get(name.as_str()) {
                Some(ColumnValues::Numbers(numbers)) => numbers.get(row).copied(),
                Some(ColumnValues::Codes(codes)) => codes.get(row).copied().map(f64::from),
                None => continue,
            };
            let logged = number(file, (row, name), field)?;
            let Some(simulated) = value else {
                return Err(RemoteLogError::Ticks { file: file.to_owned(), rows: row + 1, ticks: trace.len() as u64 });
            };
            if logged.to_bits() != simulated.to_bits() {
                let difference = Difference { tick: row as u64, column: name.clone(), logged, simulated };
                return Ok((row as u64, Some(difference)));
            }
        }
        ticks += 1;
    }
    Ok((ticks, None))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn delays_are_read_back_as_written() {
        let grid = TickGrid::new(1e-3, 5e-3).expect("valid");
        let (forward, backward) = ([0, 3, Schedule::LOST, 1, 70], [2, 2, 2, Schedule::LOST, 0]);
        let text = delays_csv(&[(Direction::Forward, &forward), (Direction::Backward, &backward)], &grid);
        assert!(
            text.starts_with("time_s,forward_delay_s,backward_delay_s\n0.0,0.0,0.002\n0.001,0.003,0.002\n0.002,lost,")
        );
        let read = |direction| read_direction("d.csv", &text, direction, &grid).expect("its own");
        assert_eq!((read(Direction::Forward), read(Direction::Backward)), (forward.to_vec(), backward.to_vec()));
    }

    #[test]
    fn a_text_that_is_no_log_is_rejected() {
        let grid = TickGrid::new(1e-3, 2e-3).expect("valid");
        let refusal = |text| read_direction("d.csv", text, Direction::Forward, &grid).expect_err(text).to_string();
        assert_eq!(refusal("time_s\n0\n"), "d.csv: there is no column forward_delay_s");
        assert_eq!(refusal("forward_delay_s\n0\nx\n"), "d.csv row 2, column forward_delay_s: \"x\" is not a number");
        assert!(refusal("forward_delay_s\n0\n").contains("1 rows, but the scenario has 2 ticks"));
        assert!(refusal("forward_delay_s,b\n0\n").starts_with("d.csv: CSV error"));
    }
}
