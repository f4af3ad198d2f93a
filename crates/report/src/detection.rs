//! The detection in one recording, as text and as CSV.

use std::fmt::Write as _;
use std::io::{self, Write};

use super::Table;
use super::columns::ColumnFormat;
use super::figures::STANDARD_ERRORS;
use super::roc::of_unit;
use super::tables::quoted;
use super::wrap::wrapped;
use trocar_document::shortest;
use trocar_document::{counted, plain, show, significant};
use trocar_engine::engine::{ColumnValues, TRUST_COLUMNS};
use trocar_metrics::Unit;
use trocar_studies::detect::{Detection, DetectionReport, PhaseStatistics, Scores};

/// Returns the result of a detection as text with tables.
#[must_use]
pub fn detection_text(name: &str, report: &DetectionReport) -> String {
    let (detector, threshold, unit) = report.detector;
    let mut text = format!(
        "{name}: {} samples over {} s, {} alarm{}\ndetector: {detector}, threshold {}\n\n",
        report.samples,
        significant(report.duration_s),
        report.alarms.len(),
        if report.alarms.len() == 1 { "" } else { "s" },
        format_args!("{}{}", significant(threshold), of_unit(unit))
    );
    if !report.alarms.is_empty() || report.missed().next().is_some() {
        let _ = writeln!(text, "{}", events_table(&[(None, report)]));
    }
    let _ = writeln!(text, "{}", phases_table(&report.phases));
    let _ = write!(text, "{}", residual_table(report));
    if let Some(scores) = &report.scores {
        let _ = writeln!(
            text,
            "\n{}: {} missed, {}\n\n{}",
            counted(scores.ruptures as u64, "labelled rupture"),
            scores.missed,
            counted(scores.false_alarms as u64, "false alarm"),
            scores_table(scores, report.window_s)
        );
        text.truncate(text.trim_end().len());
        text.push('\n');
    }
    wrapped(&text, 0)
}

/// Returns the statistics of the residual as a table.
pub(super) fn residual_table(report: &DetectionReport) -> Table {
    let mut table = Table::new(["residual", "value"]);
    let newton = |value| show(Some(value), Unit::Newton);
    table.row(["mean".to_owned(), newton(report.residual.mean_n)]);
    table.row(["standard deviation".to_owned(), newton(report.residual.std_n)]);
    table.row(["robust standard deviation".to_owned(), newton(report.residual.robust_std_n)]);
    table.row(["mean |residual|".to_owned(), newton(report.residual.mean_absolute_n)]);
    table.row(["maximum |residual|".to_owned(), newton(report.residual.max_absolute_n)]);
    table
}

/// Returns the alarms, each with its matched rupture, and the missed ruptures of recordings, in order of time.
pub(super) fn events_table(recordings: &[(Option<&str>, &DetectionReport)]) -> Table {
    let is_named = recordings.iter().any(|(name, _)| name.is_some());
    let first = if is_named { "recording, alarm" } else { "alarm" };
    let mut table = Table::new([first, "time", "position", "depth", "force", "residual", "rupture", "delay"]);
    for (name, report) in recordings {
        for event in events(report) {
            let mut cells = event.cells(report);
            if let Some(name) = name {
                cells[0] = format!("{name}, {}", cells[0]);
            }
            table.row(cells);
        }
    }
    table
}

/// An alarm or a missed rupture, by its index.
#[derive(Clone, Copy)]
enum Event {
    Alarm(usize),
    Missed(usize),
}

fn events(report: &DetectionReport) -> Vec<Event> {
    let mut events: Vec<Event> = (0..report.alarms.len()).map(Event::Alarm).collect();
    events.extend(report.missed().map(Event::Missed));
    events.sort_by(|a, b| a.time_s(report).total_cmp(&b.time_s(report)));
    events
}

impl Event {
    fn time_s(self, report: &DetectionReport) -> f64 {
        match self {
            Self::Alarm(alarm) => report.alarms[alarm].time_s,
            Self::Missed(label) => report.labelled_ruptures_s[label],
        }
    }

    /// Returns `found`, `false` or `missed` in a labelled recording, and `alarm` in a recording without labels.
    fn name(self, report: &DetectionReport) -> &'static str {
        match self {
            Self::Missed(_) => "missed",
            Self::Alarm(_) if report.scores.is_none() => "alarm",
            Self::Alarm(alarm) if report.alarms[alarm].label.is_some() => "found",
            Self::Alarm(_) => "false",
        }
    }

    fn cells(self, report: &DetectionReport) -> [String; 8] {
        let dash = || "—".to_owned();
        let rupture = |label: usize| {
            let kind = report.labelled_kinds[label].as_deref().map_or(String::new(), |kind| format!("{kind} "));
            format!("{kind}{:.4} s", report.labelled_ruptures_s[label])
        };
        match self {
            Self::Missed(label) => ["missed".into(), dash(), dash(), dash(), dash(), dash(), rupture(label), dash()],
            Self::Alarm(index) => {
                let alarm = &report.alarms[index];
                [
                    format!("{}", index + 1),
                    format!("{:.4} s", alarm.time_s),
                    show(Some(alarm.position_m), Unit::Metre),
                    show(Some(alarm.depth_m), Unit::Metre),
                    show(Some(alarm.force_n), Unit::Newton),
                    show(Some(alarm.residual_n), Unit::Newton),
                    match alarm.label {
                        Some(label) => rupture(label),
                        None if report.scores.is_some() => "false".into(),
                        None => dash(),
                    },
                    show(alarm.delay_s, Unit::Second),
                ]
            }
        }
    }
}

/// Returns the estimates by phase. A phase without samples has no row.
pub(super) fn phases_table(phases: &[PhaseStatistics]) -> Table {
    let of = |parameter: &str| format!("{parameter} ± {STANDARD_ERRORS} s.e.");
    let mut table =
        Table::new(["phase", "duration", "mean |residual|", "σ of residual", "robust σ", &of("K"), &of("B")]);
    let newton = |value| show(value, Unit::Newton);
    let with = |value: Option<f64>, std: Option<f64>, unit: &str| {
        let pair = value
            .zip(std)
            .map(|(value, std)| format!("{} ± {} {unit}", significant(value), significant(STANDARD_ERRORS * std)));
        pair.unwrap_or_else(|| "—".to_owned())
    };
    for phase in phases.iter().filter(|phase| phase.samples > 0) {
        table.row([
            phase.phase.name().to_owned(),
            format!("{} s", significant(phase.duration_s)),
            newton(phase.mean_absolute_n),
            newton(phase.std_n),
            newton(phase.robust_std_n),
            with(phase.mean_stiffness_n_per_m, phase.mean_stiffness_std_n_per_m, "N/m"),
            with(phase.mean_damping_n_s_per_m, phase.mean_damping_std_n_s_per_m, "N·s/m"),
        ]);
    }
    table
}

/// Returns the scores of one recording, one per row.
pub(super) fn scores_table(scores: &Scores, window_s: f64) -> Table {
    let mut table = Table::new([format!("alarms at most {} after a rupture", window(window_s)), "value".into()]);
    let share = |value| show(value, Unit::Share);
    table.row(["precision".to_owned(), share(scores.precision)]);
    table.row(["recall".to_owned(), share(scores.recall)]);
    table.row(["F1".to_owned(), share(scores.f1)]);
    table.row(["delay: median [range]".to_owned(), delays(scores)]);
    table.row(["false alarms per minute".to_owned(), rate(scores.false_alarms_per_minute)]);
    table.row(["false alarms per minute in contact".to_owned(), rate(scores.false_alarms_per_contact_minute)]);
    table
}

/// Returns the window of the matching in ms.
pub(super) fn window(window_s: f64) -> String {
    format!("{} ms", plain(1e3 * window_s))
}

/// Returns the median delay and its range in ms.
pub(super) fn delays(scores: &Scores) -> String {
    let (Some(median), Some(min), Some(max)) = (scores.median_delay_s, scores.min_delay_s, scores.max_delay_s) else {
        return "—".into();
    };
    let ms = |delay_s: f64| significant(1e3 * delay_s);
    format!("{} [{}, {}] ms", ms(median), ms(min), ms(max))
}

pub(super) fn rate(per_minute: Option<f64>) -> String {
    per_minute.map_or("—".into(), significant)
}

/// The header of `events.csv`.
pub const EVENT_COLUMNS: &str = "file,event,time_s,sample,position_m,depth_m,force_n,residual_n,rupture_s,kind,delay_s";

/// Returns the rows of `events.csv`: the alarms of a recording (`found`, `false`, or `alarm` without labels) and the missed
/// ruptures (`missed`), in order of time, in SI units. An undefined value is an empty cell.
#[must_use]
pub fn event_rows(file: &str, report: &DetectionReport) -> String {
    let mut text = String::new();
    let rupture = |label: Option<usize>| {
        let time_s = label.map_or(String::new(), |label| shortest(report.labelled_ruptures_s[label]));
        let kind = label.and_then(|label| report.labelled_kinds[label].as_deref()).unwrap_or_default();
        format!("{time_s},{}", quoted(kind))
    };
    for event in events(report) {
        let (file, name) = (quoted(file), event.name(report));
        let _ = match event {
            Event::Missed(label) => {
                let time_s = shortest(report.labelled_ruptures_s[label]);
                writeln!(text, "{file},{name},{time_s},,,,,,{},", rupture(Some(label)))
            }
            Event::Alarm(alarm) => {
                let alarm = &report.alarms[alarm];
                let numbers = [alarm.position_m, alarm.depth_m, alarm.force_n, alarm.residual_n].map(shortest);
                let delay = alarm.delay_s.map_or(String::new(), shortest);
                let (time_s, sample) = (shortest(alarm.time_s), alarm.sample);
                writeln!(text, "{file},{name},{time_s},{sample},{},{},{delay}", numbers.join(","), rupture(alarm.label))
            }
        };
    }
    text
}

/// Writes the samples of a detection with their estimates and decisions: the file `detection.csv`, or that of another format.
///
/// # Errors
/// Returns the errors of the writer.
pub fn write_detection(detection: &Detection, format: ColumnFormat, out: &mut (dyn Write + Send)) -> io::Result<()> {
    let columns: [(&str, &[f64]); 9] = [
        ("time_s", &detection.time_s),
        ("position_m", &detection.position_m),
        ("velocity_m_per_s", &detection.velocity_m_per_s),
        ("measured_force_n", &detection.measured_force_n),
        ("stiffness_n_per_m", &detection.stiffness_n_per_m),
        ("damping_n_s_per_m", &detection.damping_n_s_per_m),
        ("residual_n", &detection.residual_n),
        ("distance", &detection.distance),
        ("decision", &detection.decision),
    ];
    let mut columns = columns.to_vec();
    columns.extend(detection.extra_parameter.iter().map(|(name, column)| (*name, column.as_slice())));
    let trust = detection.trust();
    let trust = TRUST_COLUMNS.iter().map(|column| column.name).zip(trust.columns());
    let numbers = columns.into_iter().map(|(name, column)| (name, ColumnValues::Numbers(column)));
    let columns: Vec<_> = numbers.chain(trust).collect();
    format.write("detection", &columns, out)
}
