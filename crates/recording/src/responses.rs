use std::f64::consts::LN_10;
use std::io::Read;

use super::error::{Place, Problem};
use super::header::find;
use super::table::Rows;
use super::{Column, Limits, RecordingError};

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ResponseRow {
    pub frequency_hz: f64,
    pub magnitude: f64,
    pub phase_rad: f64,
}

const MIN_ROWS: usize = 3;

/// Columns `frequency_hz`, `magnitude` or `magnitude_db`, and `phase_deg` or `phase_rad`.
pub fn read_response<R: Read>(source: &str, reader: R, limits: &Limits) -> Result<Vec<ResponseRow>, RecordingError> {
    let names = ["frequency_hz", "magnitude", "magnitude_db", "phase_deg", "phase_rad"].map(Column::plain);
    let [frequency, magnitude, decibels, degrees, radians] = &names;
    let (mut rows, (at, (size, in_decibels), (phase, in_degrees), width)) =
        Rows::open(source, reader, &limits.of_table(), |header| {
            let either = |one: &Column, other: &Column| match find(header, other) {
                Ok(found) => Ok((found, true)),
                Err(_) => find(header, one).map(|found| (found, false)),
            };
            let (size, phase) = (either(magnitude, decibels)?, either(radians, degrees)?);
            Ok((find(header, frequency)?, size, phase, header.len()))
        })?;
    let (size_column, phase_column) =
        (if in_decibels { decibels } else { magnitude }, if in_degrees { degrees } else { radians });
    let mut table: Vec<ResponseRow> = vec![];
    while rows.next()? {
        rows.check_room(table.len(), limits.max_samples)?;
        rows.check_width(width)?;
        let frequency_hz = rows.number(at, frequency)?;
        let last_hz = table.last().map_or(0.0, |row| row.frequency_hz);
        if frequency_hz <= last_hz {
            let problem = Problem::FrequencyOutOfOrder { frequency_hz, last_hz };
            return Err(rows.place().in_column(frequency.name()).error(problem));
        }
        let size = rows.number(size, size_column)?;
        let magnitude = if in_decibels { (size * LN_10 / 20.0).exp() } else { size };
        if !(magnitude > 0.0 && magnitude.is_finite()) {
            return Err(rows.place().in_column(size_column.name()).error(Problem::MagnitudeOutOfRange(size)));
        }
        let phase = rows.number(phase, phase_column)?;
        let phase_rad = if in_degrees { phase.to_radians() } else { phase };
        table.push(ResponseRow { frequency_hz, magnitude, phase_rad });
    }
    if table.len() < MIN_ROWS {
        return Err(Place::file(source).error(Problem::TooFewFrequencies(table.len())));
    }
    Ok(table)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(table: &str) -> Result<Vec<ResponseRow>, String> {
        read_response("slave.csv", table.as_bytes(), &Limits::default()).map_err(|error| error.to_string())
    }

    #[test]
    fn magnitude_and_phase_are_read_in_both_units() {
        let plain = read("frequency_hz,magnitude,phase_rad\n1,10,0\n2,1,-1.5\n4,0.1,-3\n").expect("a response");
        let other = read(
            "phase_deg;note;frequency_hz;magnitude_db\n0;;1;20\n-85.94366926962348;x;2;0\n-171.88733853924697;;4;-20\n",
        )
        .expect("a response");
        for (a, b) in plain.iter().zip(&other) {
            assert_eq!(a.frequency_hz, b.frequency_hz);
            assert!((a.magnitude / b.magnitude - 1.0).abs() < 1e-14 && (a.phase_rad - b.phase_rad).abs() < 1e-14);
        }
        assert_eq!(plain[2], ResponseRow { frequency_hz: 4.0, magnitude: 0.1, phase_rad: -3.0 });
    }

    #[test]
    fn what_is_no_response_is_refused_with_its_place() {
        for (rows, reason) in [
            ("1,1,0\n1,1,0\n2,1,0\n", "line 3, column 'frequency_hz': 1 Hz after 1 Hz"),
            ("0,1,0\n1,1,0\n2,1,0\n", "line 2, column 'frequency_hz': 0 Hz"),
            ("1,1,0\n2,0,0\n3,1,0\n", "line 3, column 'magnitude': a magnitude of 0"),
            ("1,1,0\n2,NaN,0\n3,1,0\n", "line 3, column 'magnitude': 'NaN' is not finite"),
            ("1,1,0\n2,1\n3,1,0\n", "line 3: the row has 2 fields"),
            ("1,1,0\n2,1,0\n", "2 frequencies"),
        ] {
            let message = read(&format!("frequency_hz,magnitude,phase_deg\n{rows}")).expect_err("refused");
            assert!(message.contains(reason), "{message}");
        }
        let message = read("hz,magnitude,phase_deg\n1,1,0\n").expect_err("refused");
        assert!(message.contains("no column 'frequency_hz'"), "{message}");
        let message = read("frequency_hz,magnitude_db,phase_deg\n1,1e9,0\n2,1,0\n3,1,0\n").expect_err("refused");
        assert!(message.contains("a magnitude of 1000000000"), "{message}");
    }
}
