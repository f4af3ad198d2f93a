//! The output of a live stream: a line per event, flushed at once.

use std::io::{self, Write};

use serde_json::json;

use trocar_studies::detect::{LiveStep, LiveSummary};

/// The columns of a row.
const COLUMNS: &str = "event,time_s,sample,position_m,depth_m,velocity_m_per_s,force_n,residual_n,stiffness_n_per_m,damping_n_s_per_m,decision";

/// The format of the output.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Format {
    /// CSV rows below a header; the summary is text on standard error.
    Csv,
    /// A JSON object per line; the last one is the summary.
    Json,
}

/// Writes rows and flushes each of them before the next sample is read.
pub(super) struct RowWriter<W> {
    out: W,
    format: Format,
    numbers: ryu::Buffer,
    line: Vec<u8>,
}

impl<W: Write> RowWriter<W> {
    /// Starts the output. The CSV header is written at once.
    pub(super) fn begin(out: W, format: Format) -> io::Result<Self> {
        let mut rows = Self { out, format, numbers: ryu::Buffer::new(), line: Vec::with_capacity(256) };
        if format == Format::Csv {
            rows.line.extend_from_slice(COLUMNS.as_bytes());
            rows.end()?;
        }
        Ok(rows)
    }

    /// Writes a tick: an `alarm` or a `sample`.
    pub(super) fn tick(&mut self, event: &str, tick: &LiveStep) -> io::Result<()> {
        let (estimate, reading) = (&tick.step.estimate, &tick.reading);
        let numbers = [
            ("position_m", reading.position_m),
            ("depth_m", tick.step.depth_m),
            ("velocity_m_per_s", tick.step.velocity_m_per_s),
            ("force_n", reading.force_n),
            ("residual_n", estimate.residual_n),
            ("stiffness_n_per_m", estimate.stiffness_n_per_m),
            ("damping_n_s_per_m", estimate.damping_n_s_per_m),
            ("decision", tick.step.decision.decision),
        ];
        self.line.clear();
        let time_s = self.numbers.format(tick.time_s);
        match self.format {
            Format::Csv => write!(self.line, "{event},{time_s},{}", tick.sample)?,
            Format::Json => {
                write!(self.line, "{{\"event\":\"{event}\",\"time_s\":{time_s},\"sample\":{}", tick.sample)?;
            }
        }
        for (name, value) in numbers {
            let value = self.numbers.format(value);
            match self.format {
                Format::Csv => write!(self.line, ",{value}")?,
                Format::Json => write!(self.line, ",\"{name}\":{value}")?,
            }
        }
        if self.format == Format::Json {
            self.line.push(b'}');
        }
        self.end()
    }

    /// Returns whether the format is JSON, in which the summary is a row too.
    pub(super) fn is_json(&self) -> bool {
        self.format == Format::Json
    }

    /// Writes the summary in the JSON format; does nothing in the CSV format.
    pub(super) fn summary(&mut self, summary: &LiveSummary, rows: u64, skipped: u64, ended: &str) -> io::Result<()> {
        if self.format == Format::Csv {
            return Ok(());
        }
        let mut all = json!({ "event": "summary", "ended": ended, "rows": rows, "skipped_rows": skipped });
        if let (Some(all), Ok(serde_json::Value::Object(numbers))) =
            (all.as_object_mut(), serde_json::to_value(summary))
        {
            all.extend(numbers);
        }
        self.line.clear();
        self.line.extend_from_slice(all.to_string().as_bytes());
        self.end()
    }

    fn end(&mut self) -> io::Result<()> {
        self.line.push(b'\n');
        self.out.write_all(&self.line)?;
        self.out.flush()
    }
}
