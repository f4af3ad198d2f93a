use std::io::{self, Write};

use serde_json::json;

use trocar_detect::{LiveStep, LiveSummary};

const COLUMNS: &str = "event,time_s,sample,position_m,depth_m,velocity_m_per_s,force_n,residual_n,stiffness_n_per_m,damping_n_s_per_m,decision";

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Format {
    /// CSV rows below a header; the summary is text on standard error.
    Csv,
    /// One object per line; the last one is the summary.
    Json,
}

/// Flushes each row before the next sample is read.
pub(super) struct RowWriter<W> {
    out: W,
    format: Format,
    numbers: ryu::Buffer,
    line: Vec<u8>,
}

impl<W: Write> RowWriter<W> {
    /// Writes the CSV header at once.
    pub(super) fn begin(out: W, format: Format) -> io::Result<Self> {
        let mut rows = Self { out, format, numbers: ryu::Buffer::new(), line: Vec::with_capacity(256) };
        if format == Format::Csv {
            rows.line.extend_from_slice(COLUMNS.as_bytes());
            rows.end()?;
        }
        Ok(rows)
    }

    /// Writes a tick as the event `alarm` or `sample`.
    pub(super) fn tick(&mut self, event: &str, tick: &LiveStep) -> io::Result<()> {
        let (estimate, measurement) = (&tick.step.estimate, &tick.measurement);
        let numbers = [
            ("position_m", measurement.position_m),
            ("depth_m", tick.step.depth_m),
            ("velocity_m_per_s", tick.step.velocity_m_per_s),
            ("force_n", measurement.force_n),
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

    pub(super) fn is_json(&self) -> bool {
        self.format == Format::Json
    }

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

#[cfg(test)]
mod tests {
    use super::*;
    use trocar_core::chain::Measurement;
    use trocar_core::detector::{AlarmConditions, Decision};
    use trocar_core::estimation::Estimate;
    use trocar_detect::Step;

    /// Returns a tick whose numbers all differ.
    fn tick() -> LiveStep {
        LiveStep {
            time_s: 0.25,
            sample: 7,
            measurement: Measurement { force_n: 1.5, position_m: 0.02, velocity_m_per_s: 99.0 },
            step: Step {
                velocity_m_per_s: -0.01,
                depth_m: 0.003,
                estimate: Estimate {
                    predicted_force_n: 98.0,
                    residual_n: 0.125,
                    correction: [97.0; 2],
                    stiffness_n_per_m: 300.0,
                    damping_n_s_per_m: 4.5,
                    extra_parameter: 96.0,
                },
                decision: Decision { distance: 95.0, decision: 0.0625, alarm: true },
                conditions: AlarmConditions {
                    in_contact: true,
                    armed: true,
                    is_drop: true,
                    moves_as_required: true,
                    is_deep: true,
                    quiet_samples: 94.0,
                },
            },
        }
    }

    fn written(format: Format) -> String {
        let mut out = vec![];
        let mut rows = RowWriter::begin(&mut out, format).expect("memory");
        rows.tick("alarm", &tick()).expect("memory");
        assert_eq!(rows.is_json(), format == Format::Json);
        String::from_utf8(out).expect("text")
    }

    #[test]
    fn csv_rows_have_each_number_below_its_column_name() {
        let text = written(Format::Csv);
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines[1], "alarm,0.25,7,0.02,0.003,-0.01,1.5,0.125,300.0,4.5,0.0625");
        assert_eq!((lines.len(), lines[0]), (2, COLUMNS));
    }

    #[test]
    fn a_json_object_has_the_columns_of_csv() {
        let (json, csv) = (written(Format::Json), written(Format::Csv));
        let object: serde_json::Value = serde_json::from_str(&json).expect("one object");
        let (names, values) = csv.trim().split_once('\n').expect("two lines");
        assert_eq!(names.split(',').count(), object.as_object().expect("an object").len());
        for (name, value) in names.split(',').zip(values.split(',')) {
            let shown = object[name].as_str().map_or_else(|| object[name].to_string(), str::to_owned);
            assert_eq!(shown, value, "{name}");
        }
    }
}
