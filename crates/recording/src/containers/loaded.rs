use super::{Array, Container, Fault, Format};
use crate::error::{Problem, Row};
use crate::room::Room;

pub(crate) struct Loaded {
    arrays: Vec<Array>,
    values: Vec<Vec<f64>>,
    lines: Option<Vec<u64>>,
}

impl Loaded {
    pub(super) fn new(
        format: Format,
        arrays: Vec<Array>,
        values: Vec<Vec<f64>>,
        left_out: &[String],
    ) -> Result<Self, Problem> {
        if !super::has_signals(&arrays) {
            return Err(Problem::no_signal(format, left_out));
        }
        Ok(Self { arrays, values, lines: None })
    }

    pub(super) fn with_lines(self, lines: Vec<u64>) -> Self {
        Self { lines: Some(lines), ..self }
    }
}

impl Container for Loaded {
    fn arrays(&self) -> &[Array] {
        &self.arrays
    }

    fn values(&mut self, index: usize, _: &Room) -> Result<Vec<f64>, Fault> {
        Ok(self.values[index].clone())
    }

    fn row(&self, _index: usize, sample: usize) -> Row {
        match &self.lines {
            Some(lines) => Row::Line(lines.get(sample).copied().unwrap_or(0)),
            None => Row::Sample(sample as u64),
        }
    }
}
