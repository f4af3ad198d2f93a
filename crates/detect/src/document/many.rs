use schemars::JsonSchema;
use serde::Serialize;
use serde_json::Value as Json;

use super::{DetectionFile, data, figures, meanings, tables};
use crate::{DetectionReport, Phase, PhaseStatistics, Scores, Tally};
use tables::{delays, matched, newton, seconds, share};
use trocar_document::{Cell, Document, Section, Shown, Study, Table, Verdict, counted, json_of};
use trocar_figures::{FigureError, MAX_ROWS, TimelineRow};
use trocar_metrics::Unit;

#[derive(Debug)]
pub struct DetectionEntry {
    /// Path as the user gave it.
    pub file: String,
    /// Folder of the output files, and name in tables.
    pub name: String,
    /// An error is its message.
    pub outcome: Result<(DetectionReport, Json), String>,
}

impl DetectionEntry {
    fn report(&self) -> Option<&DetectionReport> {
        self.outcome.as_ref().ok().map(|(report, _)| report)
    }

    fn recording(&self) -> Recording<'_> {
        let outcome = match &self.outcome {
            Ok((_, detection)) => Outcome::Detection(detection),
            Err(error) => Outcome::Failure { error },
        };
        Recording { file: &self.file, folder: &self.name, outcome }
    }
}

/// `detections.json`: many recordings.
#[derive(Debug, Serialize, JsonSchema)]
pub struct DetectionsFile<'a> {
    /// Version of trocar.
    trocar_version: &'static str,
    /// The recordings, in the order in which they were given.
    recordings: Vec<Recording<'a>>,
    /// The scores over all labelled recordings; `None` if no recording has labels.
    scores: Option<Scores>,
    /// Statistics of each phase over all recordings.
    phases: Vec<PhaseStatistics>,
}

#[derive(Debug, Serialize, JsonSchema)]
struct Recording<'a> {
    /// The path of the file as the user gave it.
    file: &'a str,
    /// The folder of its output files, which is also its name in tables.
    folder: &'a str,
    #[serde(flatten)]
    outcome: Outcome<'a>,
}

#[derive(Debug, Serialize, JsonSchema)]
#[serde(untagged)]
enum Outcome<'a> {
    /// The content of `detection.json`.
    Detection(#[schemars(with = "DetectionFile<'a>")] &'a Json),
    /// A recording that cannot be read.
    Failure {
        /// The error message.
        error: &'a str,
    },
}

#[derive(Debug)]
pub struct Detections {
    pub entries: Vec<DetectionEntry>,
}

impl Study for Detections {
    fn document(&self) -> Document<'_> {
        let reports: Vec<_> = self.named().collect();
        let failed = self.entries.len() - reports.len();
        let alarms: usize = reports.iter().map(|(_, report)| report.alarms.len()).sum();
        let unreadable = (failed > 0).then(|| format!("{failed} of {} recordings cannot be read", self.entries.len()));
        let mut document = Document {
            name: "detections",
            title: counted(reports.len() as u64, "recording"),
            verdict: Verdict {
                sentences: vec![counted(alarms as u64, "alarm")],
                left_out: unreadable.into_iter().collect(),
            },
            sections: self.sections(&reports),
            data: vec![data::events(self.entries.iter().filter_map(|entry| Some((&*entry.file, entry.report()?))))],
            json: json_of(&DetectionsFile {
                trocar_version: env!("CARGO_PKG_VERSION"),
                recordings: self.entries.iter().map(DetectionEntry::recording).collect(),
                scores: self.scores(),
                phases: self.phases(),
            }),
            ..Document::default()
        };
        let rows: Vec<TimelineRow<'_>> =
            reports.iter().take(MAX_ROWS).map(|(name, report)| figures::row(name, report, 0.0)).collect();
        document.figure("timeline", trocar_figures::timeline(&rows));
        let delays: Result<_, FigureError> = trocar_figures::delay_histogram(&delays_s(&reports));
        if delays.is_ok() {
            let mut section = Section::new("delays", "Detection delays").shown(Shown::InReports);
            section.figure("delays");
            document.sections.push(section);
        }
        document.figure("delays", delays);
        document
    }
}

fn delays_s(reports: &[(&str, &DetectionReport)]) -> Vec<f64> {
    reports.iter().flat_map(|(_, report)| &report.alarms).filter_map(|alarm| alarm.delay_s).collect()
}

impl Detections {
    fn named(&self) -> impl Iterator<Item = (&str, &DetectionReport)> {
        self.entries.iter().filter_map(|entry| Some((&*entry.name, entry.report()?)))
    }

    fn scores(&self) -> Option<Scores> {
        let tallies: Vec<&Tally> = self.named().filter_map(|(_, report)| report.tally.as_ref()).collect();
        let mut all = Tally::default();
        tallies.iter().for_each(|tally| all.add(tally));
        (!tallies.is_empty()).then(|| Scores::of(&all))
    }

    fn phases(&self) -> Vec<PhaseStatistics> {
        let of = |phase| PhaseStatistics::pooled(phase, self.named().flat_map(|(_, report)| &report.phases));
        Phase::ALL.map(of).to_vec()
    }

    fn sections(&self, reports: &[(&str, &DetectionReport)]) -> Vec<Section> {
        let mut pages = Section::new("pages", "Pages").shown(Shown::InReports);
        pages.text("Each recording has its own page in the folder with its name.");
        let mut sections = vec![pages];
        let named: Vec<_> = reports.iter().map(|(name, report)| (Some(*name), *report)).collect();
        let events = tables::events(&named);
        if !events.rows.is_empty() {
            let mut section = Section::new("events", "Events");
            section.table(events);
            section.table(missed(reports));
            sections.push(section);
        }
        let mut timeline = Section::new("timeline", "Timeline").shown(Shown::InReports);
        if !reports.is_empty() {
            timeline.figure("timeline");
        }
        if reports.len() > MAX_ROWS {
            timeline.text(format!("The timeline shows the first {MAX_ROWS} of {} recordings.", reports.len()));
        }
        sections.push(timeline);
        let mut results = Section::new("metrics", "Results");
        results.table(self.recordings_table());
        if let Some(scores) = self.scores() {
            results.table(self.scores_table(&scores));
        }
        sections.push(results);
        let untouched: Vec<&str> =
            reports.iter().filter(|(_, report)| !report.touched).map(|(name, _)| *name).collect();
        if !untouched.is_empty() {
            let mut section = Section::new("contact", "Contact");
            let names = untouched.join(", ");
            section.text(format!("The needle never passes the contact position in {names}. Set it with --contact-m."));
            sections.push(section);
        }
        if !reports.is_empty() {
            let mut phases = Section::new("phases", "Phases");
            phases.table(tables::phases("Estimates by phase, all recordings", &self.phases()));
            sections.push(phases);
        }
        sections.push(meanings());
        sections
    }

    fn recordings_table(&self) -> Table {
        let columns = [
            ("recording", "recording"),
            ("samples", "samples"),
            ("duration_s", "duration"),
            ("contact_s", "contact"),
            ("mean_absolute_n", "mean |residual|"),
            ("std_n", "σ of residual"),
            ("robust_std_n", "robust σ"),
            ("alarms", "alarms"),
        ];
        let mut table = Table::new("recordings", "Recordings", columns);
        let count = |count: usize| Cell::count(count as u64);
        for entry in &self.entries {
            let mut cells = [const { Cell::Undefined }; 8];
            if let Some(report) = entry.report() {
                let residual = &report.residual;
                cells = [
                    Cell::Undefined,
                    count(report.samples),
                    seconds(report.duration_s),
                    seconds(report.contact_s),
                    newton(residual.mean_absolute_n),
                    newton(residual.std_n),
                    newton(residual.robust_std_n),
                    count(report.alarms.len()),
                ];
            }
            cells[0] = entry.name.as_str().into();
            table.row(cells);
        }
        let reports = || self.named().map(|(_, report)| report);
        let samples: usize = reports().map(|report| report.samples).sum();
        let mean = |value: &dyn Fn(&DetectionReport) -> f64| {
            let sum: f64 = reports().map(|report| value(report) * report.samples as f64).sum();
            (samples > 0).then(|| sum / samples as f64)
        };
        table.row([
            format!("all {}", reports().count()).into(),
            count(samples),
            seconds(reports().map(|report| report.duration_s).sum()),
            seconds(reports().map(|report| report.contact_s).sum()),
            Cell::of(mean(&|report| report.residual.mean_absolute_n), Unit::Newton),
            Cell::of(mean(&|report| report.residual.std_n.powi(2)).map(f64::sqrt), Unit::Newton),
            Cell::Undefined,
            count(reports().map(|report| report.alarms.len()).sum()),
        ]);
        table
    }

    fn scores_table(&self, total: &Scores) -> Table {
        let within_s = self.named().next().map(|(_, report)| report.within_s);
        let columns = [
            ("recording", matched(within_s)),
            ("ruptures", "ruptures".into()),
            ("found", "found".into()),
            ("missed", "missed".into()),
            ("false_alarms", "false".into()),
            ("precision", "precision".into()),
            ("recall", "recall".into()),
            ("f1", "F1".into()),
            ("delay_s", "delay: median [range]".into()),
            ("false_alarms_per_minute", "false/min".into()),
            ("false_alarms_per_contact_minute", "in contact".into()),
        ];
        let mut table = Table::new("scores", "Alarms compared with the labels", columns);
        let of_all = format!("all {} labelled", total.recordings);
        let each = self.named().filter_map(|(name, report)| Some((name, report.scores.as_ref()?)));
        for (name, scores) in each.chain([(&*of_all, total)]) {
            table.row([
                name.into(),
                Cell::count(scores.ruptures as u64),
                Cell::count(scores.found as u64),
                Cell::count(scores.missed as u64),
                Cell::count(scores.false_alarms as u64),
                share(scores.precision),
                share(scores.recall),
                share(scores.f1),
                delays(scores),
                Cell::si(scores.false_alarms_per_minute, ""),
                Cell::si(scores.false_alarms_per_contact_minute, ""),
            ]);
        }
        table
    }
}

fn missed(reports: &[(&str, &DetectionReport)]) -> Table {
    let columns = [("rupture", "missed rupture"), ("reason", "reason")];
    let mut table = Table::new("misses", "Why ruptures were missed", columns).of_text().shown(Shown::InReports);
    for (name, report) in reports {
        for miss in &report.misses {
            table.row([format!("{name}, rupture {} at {} s", miss.label + 1, miss.time_s), miss.miss.to_string()]);
        }
    }
    table
}
