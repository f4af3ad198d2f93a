use crate::{DetectionReport, PhaseStatistics, Scores};
use trocar_document::{Cell, Digits, Number, Table, plain};
use trocar_figures::STANDARD_ERRORS;
use trocar_metrics::Unit;

const EVENTS_ON_TERMINAL: usize = 20;

pub(super) fn newton(value: f64) -> Cell {
    Cell::of(Some(value), Unit::Newton)
}

pub(super) fn seconds(value: f64) -> Cell {
    Cell::si(Some(value), "s")
}

pub(super) fn residual(report: &DetectionReport) -> Table {
    let columns = [("quantity", "residual"), ("value", "value")];
    let mut table = Table::new("residual", "Residual: measured minus estimated force", columns);
    let residual = &report.residual;
    table.row(["mean".into(), newton(residual.mean_n)]);
    table.row(["standard deviation".into(), newton(residual.std_n)]);
    table.row(["robust standard deviation".into(), newton(residual.robust_std_n)]);
    table.row(["mean |residual|".into(), newton(residual.mean_absolute_n)]);
    table.row(["maximum |residual|".into(), newton(residual.max_absolute_n)]);
    table
}

pub(super) fn events(recordings: &[(Option<&str>, &DetectionReport)]) -> Table {
    let is_named = recordings.iter().any(|(name, _)| name.is_some());
    let columns = [
        ("alarm", if is_named { "recording, alarm" } else { "alarm" }),
        ("time_s", "time"),
        ("position_m", "position"),
        ("depth_m", "depth"),
        ("force_n", "force"),
        ("residual_n", "residual"),
        ("rupture", "rupture"),
        ("delay_s", "delay"),
    ];
    let table = Table::new("events", "Alarms and missed ruptures", columns);
    let mut table = table.first_rows(EVENTS_ON_TERMINAL, "events.csv");
    for (name, report) in recordings {
        for event in Event::all(report) {
            let mut cells = event.cells(report);
            if let Some(name) = name {
                cells[0] = format!("{name}, {}", cells[0]).into();
            }
            table.row(cells);
        }
    }
    table
}

#[derive(Clone, Copy)]
pub(super) enum Event {
    Alarm(usize),
    Missed(usize),
}

impl Event {
    pub(super) fn all(report: &DetectionReport) -> Vec<Self> {
        let mut events: Vec<Self> = (0..report.alarms.len()).map(Self::Alarm).collect();
        events.extend(report.missed().map(Self::Missed));
        events.sort_by(|a, b| a.time_s(report).total_cmp(&b.time_s(report)));
        events
    }

    pub(super) fn time_s(self, report: &DetectionReport) -> f64 {
        match self {
            Self::Alarm(alarm) => report.alarms[alarm].time_s,
            Self::Missed(label) => report.labelled_ruptures_s[label],
        }
    }

    fn cells(self, report: &DetectionReport) -> [Cell; 8] {
        let time = |time_s: f64| Number::si(time_s, "s").digits(Digits::Decimals(4));
        let rupture = |label: usize| {
            let kind = report.labelled_kinds[label].as_deref().map_or(String::new(), |kind| format!("{kind} "));
            Cell::Text(format!("{kind}{}", time(report.labelled_ruptures_s[label])))
        };
        let metre = |value| Cell::of(Some(value), Unit::Metre);
        match self {
            Self::Missed(label) => {
                let mut cells = [const { Cell::Undefined }; 8];
                (cells[0], cells[6]) = ("missed".into(), rupture(label));
                cells
            }
            Self::Alarm(index) => {
                let alarm = &report.alarms[index];
                [
                    format!("{}", index + 1).into(),
                    time(alarm.time_s).into(),
                    metre(alarm.position_m),
                    metre(alarm.depth_m),
                    newton(alarm.force_n),
                    newton(alarm.residual_n),
                    match alarm.label {
                        Some(label) => rupture(label),
                        None if report.scores.is_some() => "false".into(),
                        None => Cell::Undefined,
                    },
                    Cell::of(alarm.delay_s, Unit::Second),
                ]
            }
        }
    }
}

pub(super) fn phases(caption: &'static str, phases: &[PhaseStatistics]) -> Table {
    let of = |parameter: &str| format!("{parameter} ± {STANDARD_ERRORS} s.e.");
    let columns = [
        ("phase", "phase".to_owned()),
        ("duration_s", "duration".to_owned()),
        ("mean_absolute_n", "mean |residual|".to_owned()),
        ("std_n", "σ of residual".to_owned()),
        ("robust_std_n", "robust σ".to_owned()),
        ("stiffness_n_per_m", of("K")),
        ("damping_n_s_per_m", of("B")),
    ];
    let mut table = Table::new("phases", caption, columns);
    let newton = |value| Cell::of(value, Unit::Newton);
    let with = |value: Option<f64>, std: Option<f64>, unit: &str| match (value, std) {
        (Some(value), Some(std)) => Cell::PlusMinus(Number::si(value, unit), STANDARD_ERRORS * std),
        _ => Cell::Undefined,
    };
    for phase in phases.iter().filter(|phase| phase.samples > 0) {
        table.row([
            phase.phase.name().into(),
            seconds(phase.duration_s),
            newton(phase.mean_absolute_n),
            newton(phase.std_n),
            newton(phase.robust_std_n),
            with(phase.mean_stiffness_n_per_m, phase.mean_stiffness_std_n_per_m, "N/m"),
            with(phase.mean_damping_n_s_per_m, phase.mean_damping_std_n_s_per_m, "N·s/m"),
        ]);
    }
    table
}

pub(super) fn scores(scores: &Scores, within_s: f64) -> Table {
    let columns = [("score", matched(Some(within_s))), ("value", "value".into())];
    let mut table = Table::new("scores", "Alarms compared with the labels", columns);
    table.row(["precision".into(), share(scores.precision)]);
    table.row(["recall".into(), share(scores.recall)]);
    table.row(["F1".into(), share(scores.f1)]);
    table.row(["delay: median [range]".into(), delays(scores)]);
    table.row(["false alarms per minute".into(), Cell::si(scores.false_alarms_per_minute, "")]);
    table.row(["false alarms per minute in contact".into(), Cell::si(scores.false_alarms_per_contact_minute, "")]);
    table
}

pub(super) fn share(value: Option<f64>) -> Cell {
    Cell::of(value, Unit::Share)
}

pub(super) fn matched(within_s: Option<f64>) -> String {
    let window = within_s.map_or("—".into(), |within_s| format!("{} ms", plain(1e3 * within_s)));
    format!("alarms at most {window} after a rupture")
}

pub(super) fn delays(scores: &Scores) -> Cell {
    match (scores.median_delay_s, scores.min_delay_s, scores.max_delay_s) {
        (Some(median), Some(min), Some(max)) => Cell::Interval(Number::milliseconds(median), [min, max]),
        _ => Cell::Undefined,
    }
}
