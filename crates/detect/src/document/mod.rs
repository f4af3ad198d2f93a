mod data;
mod figures;
mod live;
mod many;
mod signals;
mod tables;

pub use data::column_values;
pub use live::live_text;
pub use many::{DetectionEntry, Detections, DetectionsFile};
pub use signals::{SignalsFile, signals_document};

use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::Serialize;
use serde_json::Value as Json;

use crate::{Detection, DetectionReport};
use trocar_document::{Cell, Document, Number, Section, Shown, Study, Verdict, Window, counted, json_of, significant};
use trocar_engine::engine::TrustColumns;
use trocar_metrics::Unit;
use trocar_scenario::{Values, json_schema};

const MAX_WINDOWS: usize = 6;

/// Maximum number of alarms in the first sentence.
const MAX_TIMES: usize = 5;

const MEANINGS: &str = "The residual e is the measured minus the estimated force. σ is its standard deviation. The \
     robust σ is 1.4826 times its median absolute deviation, which ruptures hardly change. K and B are the means of \
     the estimated stiffness and damping, s.e. is the mean of their standard error: a B within two standard errors of \
     0, as in a hold, is not known. The phase is free without contact; the mean speed of the needle distinguishes \
     insertion, hold and withdrawal. Precision is the share of alarms that match a rupture, recall is the share of \
     ruptures with a matching alarm, and F1 is their harmonic mean. A delay is the time from a rupture to its alarm.";

#[derive(Debug)]
pub struct DetectionStudy {
    pub name: String,
    pub file: String,
    pub values: Values,
    pub report: DetectionReport,
    pub is_drawn: bool,
    samples: Samples,
}

impl DetectionStudy {
    pub fn new(name: String, file: String, values: Values, (detection, report): (Detection, DetectionReport)) -> Self {
        let samples = Samples::of(detection);
        Self { name, file, values, report, is_drawn: true, samples }
    }
}

#[derive(Debug)]
pub(crate) struct Samples {
    detection: Detection,
    trust: TrustColumns,
    alarms_s: Vec<f64>,
}

impl Samples {
    pub(crate) fn of(detection: Detection) -> Self {
        let alarms_s = detection.alarms.iter().map(|&sample| detection.time_s[sample]).collect();
        Self { trust: detection.trust(), alarms_s, detection }
    }
}

impl Study for DetectionStudy {
    fn document(&self) -> Document<'_> {
        let mut document = report_document(&self.name, &self.report, &self.values);
        document.data = vec![data::samples(&self.samples), data::events([(&*self.file, &self.report)])];
        if self.is_drawn {
            let name = self.values.name();
            self.samples.draw(&mut document, "", name, &self.report);
            add_timeline(&mut document, name, &self.report);
            let [signals, residual] = signals(&self.report);
            document.sections.insert(0, signals);
            document.sections.push(residual);
        }
        document
    }
}

pub fn add_timeline(document: &mut Document<'_>, name: &str, report: &DetectionReport) {
    document.figure("timeline", trocar_figures::timeline(&[figures::row(name, report, report.start_s)]));
}

pub fn report_document(name: &str, report: &DetectionReport, values: &Values) -> Document<'static> {
    let (detector, threshold, unit) = report.detector;
    let samples = format!(
        "{} samples over {} s, {}{}.",
        report.samples,
        significant(report.duration_s),
        counted(report.alarms.len() as u64, "alarm"),
        alarm_times(report)
    );
    let mut events = Section::new("events", "Events");
    if report.alarms.is_empty() && report.missed().next().is_none() {
        events = events.shown(Shown::InReports);
        events.text("No alarm.");
    } else {
        events.table(tables::events(&[(None, report)]));
    }
    let mut results = Section::new("metrics", "Results");
    results.table(tables::phases("Estimates by phase", &report.phases));
    results.table(tables::residual(report));
    let mut sections = vec![events, results];
    let mut sentences = vec![samples];
    if let Some(scores) = &report.scores {
        sentences.push(format!(
            "{} of {} missed, {}.",
            scores.missed,
            counted(scores.ruptures as u64, "labelled rupture"),
            counted(scores.false_alarms as u64, "false alarm"),
        ));
        let mut section = Section::new("labels", "Labels");
        section.table(tables::scores(scores, report.within_s));
        sections.push(section);
    }
    sentences.extend(report.notes.iter().cloned());
    sections.push(meanings());
    Document {
        name: "detection",
        title: name.to_owned(),
        verdict: Verdict {
            sentences,
            left_out: vec![format!("detector: {detector}, threshold {}", Number::si(threshold, unit))],
        },
        warnings: report.warnings.clone(),
        sections,
        json: json(name, report, values),
        ..Document::default()
    }
}

fn alarm_times(report: &DetectionReport) -> String {
    let times: Vec<String> =
        report.alarms.iter().take(MAX_TIMES).map(|alarm| format!("{:.3} s", alarm.time_s)).collect();
    let more = report.alarms.len() - times.len();
    match &*times {
        [] => String::new(),
        times if more > 0 => format!(" at {} and {more} later", times.join(", ")),
        [one] => format!(" at {one}"),
        [others @ .., last] => format!(" at {} and {last}", others.join(", ")),
    }
}

fn meanings() -> Section {
    let mut section = Section::new("meanings", "Meanings").shown(Shown::InReports);
    section.text(MEANINGS);
    section
}

fn signals(report: &DetectionReport) -> [Section; 2] {
    let mut signals = Section::new("signals", "Signals").shown(Shown::InReports);
    signals.text(format!(
        "The samples are {} apart, {} s of them in contact",
        Cell::of(Some(report.interval_s), Unit::Second),
        significant(report.contact_s)
    ));
    let window = |label: String, at: f64| Window { label, range: ((at - 0.1).max(report.start_s), at + 0.4) };
    let alarms = report.alarms.iter().enumerate().take(MAX_WINDOWS);
    let windows = alarms.map(|(index, alarm)| window(format!("alarm {}", index + 1), alarm.time_s)).collect();
    signals.figures(["timeline", "estimation", "parameters", "decision"], windows);
    signals.text(
        "Long records are reduced to the minimum and maximum of short intervals; nearly every sample around ruptures \
         and alarms is kept. detection.csv has every sample.",
    );
    let mut residual = Section::new("residual", "Distribution of the residual").shown(Shown::InReports);
    residual.figure("residual");
    [signals, residual]
}

/// `detection.json`: the alarms, the statistics of the estimates, the scores and the settings.
#[derive(Debug, Serialize, JsonSchema)]
#[schemars(inline)]
pub struct DetectionFile<'a> {
    /// Version of trocar.
    trocar_version: &'static str,
    /// Name of the recording.
    recording: &'a str,
    settings: ChainSettings,
    #[serde(flatten)]
    report: &'a DetectionReport,
}

/// The settings of estimator and detector, with the keys of a scenario file.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct ChainSettings {
    #[schemars(schema_with = "estimator_schema")]
    pub(crate) estimator: Json,
    #[schemars(schema_with = "detector_schema")]
    pub(crate) detector: Json,
}

fn estimator_schema(_: &mut SchemaGenerator) -> Schema {
    section_schema("estimator")
}

fn detector_schema(_: &mut SchemaGenerator) -> Schema {
    section_schema("detector")
}

fn section_schema(name: &str) -> Schema {
    json_schema()["properties"][name].take().try_into().unwrap_or_default()
}

fn json(name: &str, report: &DetectionReport, values: &Values) -> Json {
    let [estimator, detector] = ["estimator", "detector"].map(|section| values.section_json(section));
    let settings = ChainSettings { estimator, detector };
    json_of(&DetectionFile { trocar_version: env!("CARGO_PKG_VERSION"), recording: name, settings, report })
}
