use super::{Columns, Limits, Recording, RecordingError, read_csv};

pub(super) fn columns() -> Columns {
    Columns {
        time: "t".parse().expect("a column"),
        position: "x".parse().expect("a column"),
        velocity: None,
        force: "f".parse().expect("a column"),
    }
}

pub(super) fn read(table: impl AsRef<[u8]>) -> Result<Recording, RecordingError> {
    read_csv("pop.csv", table.as_ref(), &columns(), &Limits::default())
}

pub(super) fn refusal(table: impl AsRef<[u8]>) -> String {
    read(table).expect_err("refused").to_string()
}

/// A recording of positions at times, with a force of twice the position and no limit on gaps.
pub(super) fn recording(time_s: &[f64], position_m: &[f64]) -> Recording {
    let rows = time_s.iter().zip(position_m);
    let rows: String = rows.map(|(t, x)| format!("{t},{x},{}\n", 2.0 * x)).collect();
    let limits = Limits { max_gap_s: Some(f64::INFINITY), ..Limits::default() };
    let table = format!("t,x,f\n{rows}");
    read_csv("pop.csv", table.as_bytes(), &columns(), &limits).expect("a recording")
}
