//! Detection on standard input, in constant memory.

use std::io;

use super::DetectArgs;
use super::rows::{Format, RowWriter};
use super::source::{Event, StandardInput};
use super::warnings::LiveWarnings;
use crate::cli::error::Failure;
use crate::cli::recorded::of_flags;
use crate::cli::terminal::closed;
use crate::cli::warnings::text as warning_text;
use trocar_detect::live_text;
use trocar_detect::sampling_rate;
use trocar_detect::{ASSUMED_STEP_M, LiveDetector, LiveStep, LiveSummary, VelocitySource};
use trocar_document::counted;
use trocar_recording::{LiveLine, LiveTable, RecordingError};
use trocar_report::wrapped;
use trocar_scenario::{DetectionSettings, Reader, Values, keys_without_effect, recording_columns};

const END: &str = "end of input";

/// The name in messages.
const NAME: &str = "standard input";

pub(super) fn run(args: &DetectArgs) -> Result<(), Failure> {
    let values = Values::from_settings("stream", &args.settings(None)).map_err(of_flags)?;
    let mut values = values.with_adaptive_detector();
    let settings = DetectionSettings::resolve(&mut values).map_err(of_flags)?;
    let columns = recording_columns(&mut values).map_err(of_flags)?;
    let warnings = LiveWarnings::new(args.output.quiet);
    let given = args.settings(None);
    for warning in keys_without_effect(&values, &given, Reader::Stream) {
        warnings.note(warning_text(&warning.of(NAME)).trim_end());
    }
    let velocity = match (&columns.velocity, settings.position_resolution_m) {
        (Some(_), _) => VelocitySource::Measured,
        (None, step_m) if step_m > 0.0 => VelocitySource::Filtered { step_m },
        (None, _) => {
            warnings.note("no --velocity: the velocity is estimated from positions with an assumed resolution of 1 µm; set the resolution of the encoder with --set sensor.position_resolution_m");
            VelocitySource::Filtered { step_m: ASSUMED_STEP_M }
        }
    };
    let format = if args.output.json { Format::Json } else { Format::Csv };
    let detector = LiveDetector::new(settings, args.interval_s, velocity)?;
    let rows = match RowWriter::begin(io::stdout(), format) {
        Ok(rows) => rows,
        Err(error) => return closed(error),
    };
    let table = LiveTable::new(NAME, columns);
    let mut session =
        Session { table, detector, rows, every: args.every, warnings, lines: 0, malformed: 0, is_rate_checked: false };
    let mut source = StandardInput::open();
    let ended = loop {
        let outcome = match source.next() {
            Event::Bytes(bytes) => session.take(bytes),
            Event::End => break session.finish().map(|()| END),
            Event::Stop => break Ok("signal"),
            Event::Failed(error) => {
                break Err(Ended::Failed(Failure::work(format!("cannot read standard input: {error}"))));
            }
        };
        if let Err(end) = outcome {
            break Err(end);
        }
    };
    match ended {
        Ok(ended) => session.summarise(ended),
        Err(Ended::OutputClosed) => Ok(()),
        // Print the results so far even if the stream fails.
        Err(Ended::Failed(error)) if session.lines > 0 => session.summarise("failure").and(Err(error)),
        Err(Ended::Failed(error)) => Err(error),
    }
}

enum Ended {
    /// The reader of the output is closed.
    OutputClosed,
    Failed(Failure),
}

impl From<io::Error> for Ended {
    fn from(error: io::Error) -> Self {
        closed(error).map_or_else(Self::Failed, |()| Self::OutputClosed)
    }
}

struct Session {
    table: LiveTable,
    detector: LiveDetector,
    rows: RowWriter<io::Stdout>,
    every: Option<u64>,
    warnings: LiveWarnings,
    lines: u64,
    /// Rows that are no valid samples.
    malformed: u64,
    /// True after the interval has been checked.
    is_rate_checked: bool,
}

impl Session {
    fn take(&mut self, mut bytes: &[u8]) -> Result<(), Ended> {
        while let Some(line) = self.table.next(&mut bytes) {
            self.line(line)?;
        }
        Ok(())
    }

    /// Processes the last line if it has no line feed.
    fn finish(&mut self) -> Result<(), Ended> {
        self.table.finish().map_or(Ok(()), |line| self.line(line))
    }

    #[inline]
    fn line(&mut self, line: Result<LiveLine, RecordingError>) -> Result<(), Ended> {
        let sample = match line {
            Ok(LiveLine::Sample(sample)) => sample,
            Ok(LiveLine::Nothing) => return Ok(()),
            Err(error) if !self.table.has_header() => return Err(Ended::Failed(error.into())),
            Err(error) => {
                self.lines += 1;
                self.malformed += 1;
                // The rows of a live rig cannot be corrected.
                self.warnings.warn(|| {
                    let error = error.to_string();
                    format!("{}; the row is skipped", error.split("; ").next().unwrap_or(&error))
                });
                return Ok(());
            }
        };
        self.lines += 1;
        let (rows, every) = (&mut self.rows, self.every);
        let mut written = Ok(());
        let emit = |tick: &LiveStep| {
            if tick.step.decision.alarm && written.is_ok() {
                written = rows.tick("alarm", tick);
            }
            if every.is_some_and(|every| tick.sample.is_multiple_of(every)) && written.is_ok() {
                written = rows.tick("sample", tick);
            }
        };
        let anomaly = self.detector.take(&sample, emit).map_err(|error| Ended::Failed(error.into()))?;
        if !self.is_rate_checked
            && let Some(interval_s) = self.detector.interval_s()
        {
            self.is_rate_checked = true;
            if let Some(warning) = sampling_rate(interval_s) {
                self.warnings.note(warning_text(&warning.of(NAME)).trim_end());
            }
        }
        if let Some(anomaly) = anomaly {
            let line = self.table.lines();
            self.warnings.warn(|| format!("{NAME} line {line}: {}", super::warnings::text(&anomaly)));
        }
        Ok(written?)
    }

    /// A stream without a sample is an error.
    fn summarise(&mut self, ended: &str) -> Result<(), Failure> {
        let summary: LiveSummary = self.detector.summary();
        let skipped = self.malformed + summary.not_later;
        self.warnings.flush();
        if summary.samples == 0 && ended == END {
            return Err(Failure::input(format!(
                "standard input: {} without the two usable samples that are needed; see --help for the columns",
                counted(self.lines, "row")
            )));
        }
        self.rows.summary(&summary, self.lines, skipped, ended).or_else(closed)?;
        if !self.rows.is_json() {
            self.warnings.note(&wrapped(&live_text(&summary, self.lines, self.malformed, ended), 0));
        }
        Ok(())
    }
}
