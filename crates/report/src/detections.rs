//! Detections in many recordings, as text and as JSON.

use std::fmt::Write as _;

use serde_json::{Value as Json, json};

use super::Table;
use super::detection::{delays, events_table, phases_table, rate, window};
use super::json::render;
use super::wrap::wrapped;
use trocar_document::{show, significant};
use trocar_metrics::Unit;
use trocar_studies::detect::{DetectionReport, Phase, PhaseStatistics, Scores, Tally};

/// One recording among many.
#[derive(Debug)]
pub struct DetectionEntry {
    /// The path of the file as the user gave it.
    pub file: String,
    /// The folder of its output files, and its name in tables.
    pub name: String,
    /// The report and its JSON, or the error message.
    pub outcome: Result<(DetectionReport, Json), String>,
}

impl DetectionEntry {
    pub(super) fn report(&self) -> Option<&DetectionReport> {
        self.outcome.as_ref().ok().map(|(report, _)| report)
    }
}

/// Returns the scores over all labelled recordings, or `None` if no recording has labels.
#[must_use]
pub fn pooled_scores(entries: &[DetectionEntry]) -> Option<Scores> {
    let tallies: Vec<&Tally> = entries.iter().filter_map(|entry| entry.report()?.tally.as_ref()).collect();
    let mut all = Tally::default();
    tallies.iter().for_each(|tally| all.add(tally));
    (!tallies.is_empty()).then(|| Scores::of(&all))
}

pub(super) fn pooled_phases(entries: &[DetectionEntry]) -> Vec<PhaseStatistics> {
    let of = |phase| {
        let reports = entries.iter().filter_map(DetectionEntry::report);
        PhaseStatistics::pooled(phase, reports.flat_map(|report| &report.phases))
    };
    Phase::ALL.map(of).to_vec()
}

/// Returns the result as text: the events, a row per recording and a total, the scores of labelled recordings, and the
/// estimates by phase. A recording that cannot be read has a row without numbers.
#[must_use]
pub fn detections_text(entries: &[DetectionEntry]) -> String {
    let reports: Vec<_> =
        entries.iter().filter_map(|entry| Some((Some(entry.name.as_str()), entry.report()?))).collect();
    let mut text = String::new();
    if reports.iter().any(|(_, report)| !report.alarms.is_empty() || report.missed().next().is_some()) {
        let _ = writeln!(text, "{}", events_table(&reports));
    }
    let _ = writeln!(text, "{}", recordings_table(entries));
    if let Some(scores) = scores_table(entries) {
        let _ = writeln!(text, "{scores}");
    }
    let untouched: Vec<&str> =
        reports.iter().filter(|(_, report)| !report.touched).filter_map(|(name, _)| *name).collect();
    if !untouched.is_empty() {
        let names = untouched.join(", ");
        let _ = writeln!(text, "The needle never passes the contact position in {names}. Set it with --contact-m.\n");
    }
    if !reports.is_empty() {
        let _ = write!(text, "{}", phases_table(&pooled_phases(entries)));
    }
    wrapped(&text, 0)
}

pub(super) fn recordings_table(entries: &[DetectionEntry]) -> Table {
    let heading =
        ["recording", "samples", "duration", "contact", "mean |residual|", "σ of residual", "robust σ", "alarms"];
    let mut table = Table::new(heading);
    let newton = |value| show(Some(value), Unit::Newton);
    let seconds = |value| format!("{} s", significant(value));
    for entry in entries {
        let Some(report) = entry.report() else {
            table.row([entry.name.as_str(), "—", "—", "—", "—", "—", "—", "—"]);
            continue;
        };
        let residual = &report.residual;
        table.row([
            entry.name.clone(),
            report.samples.to_string(),
            seconds(report.duration_s),
            seconds(report.contact_s),
            newton(residual.mean_absolute_n),
            newton(residual.std_n),
            newton(residual.robust_std_n),
            report.alarms.len().to_string(),
        ]);
    }
    let reports = || entries.iter().filter_map(DetectionEntry::report);
    let samples: usize = reports().map(|report| report.samples).sum();
    let mean = |value: &dyn Fn(&DetectionReport) -> f64| {
        let sum: f64 = reports().map(|report| value(report) * report.samples as f64).sum();
        (samples > 0).then(|| sum / samples as f64)
    };
    table.row([
        format!("all {}", reports().count()),
        samples.to_string(),
        seconds(reports().map(|report| report.duration_s).sum()),
        seconds(reports().map(|report| report.contact_s).sum()),
        show(mean(&|report| report.residual.mean_absolute_n), Unit::Newton),
        show(mean(&|report| report.residual.std_n.powi(2)).map(f64::sqrt), Unit::Newton),
        "—".to_owned(),
        reports().map(|report| report.alarms.len()).sum::<usize>().to_string(),
    ]);
    table
}

/// Returns the scores of each labelled recording and of all of them, or `None` if no recording has labels.
pub(super) fn scores_table(entries: &[DetectionEntry]) -> Option<Table> {
    let total = pooled_scores(entries)?;
    let window_s = entries.iter().find_map(DetectionEntry::report).map(|report| report.window_s);
    let heading = [
        format!("alarms at most {} after a rupture", window_s.map_or("—".into(), window)),
        "ruptures".into(),
        "found".into(),
        "missed".into(),
        "false".into(),
        "precision".into(),
        "recall".into(),
        "F1".into(),
        "delay: median [range]".into(),
        "false/min".into(),
        "in contact".into(),
    ];
    let mut table = Table::new(heading);
    let mut add = |name: String, scores: &Scores| {
        table.row([
            name,
            scores.ruptures.to_string(),
            scores.found.to_string(),
            scores.missed.to_string(),
            scores.false_alarms.to_string(),
            show(scores.precision, Unit::Share),
            show(scores.recall, Unit::Share),
            show(scores.f1, Unit::Share),
            delays(scores),
            rate(scores.false_alarms_per_minute),
            rate(scores.false_alarms_per_contact_minute),
        ]);
    };
    for entry in entries {
        if let Some(scores) = entry.report().and_then(|report| report.scores.as_ref()) {
            add(entry.name.clone(), scores);
        }
    }
    add(format!("all {} labelled", total.recordings), &total);
    Some(table)
}

/// Returns `detections.json`: for each recording its path and its `detection.json` or its error; then the pooled scores and
/// phases.
#[must_use]
pub fn detections_json(entries: &[DetectionEntry]) -> String {
    let one = |entry: &DetectionEntry| {
        let mut all = json!({ "file": entry.file, "folder": entry.name });
        let Json::Object(object) = &mut all else { return all };
        match &entry.outcome {
            Ok((_, Json::Object(detection))) => object.extend(detection.clone()),
            Ok(_) => {}
            Err(error) => {
                object.insert("error".into(), json!(error));
            }
        }
        all
    };
    render(&json!({
        "trocar_version": env!("CARGO_PKG_VERSION"),
        "recordings": entries.iter().map(one).collect::<Vec<_>>(),
        "scores": pooled_scores(entries),
        "phases": pooled_phases(entries),
    }))
}
