//! The pages of detections in one recording and in many.

use super::compared::without_paths;
use super::events::{self, LaneEvents, Mark, Timeline};
use super::page::{Block, Drawn, HtmlError, Page, Section, Window, warned};
use crate::DetectionEntry;
use crate::detection::{events_table, phases_table, residual_table, scores_table};
use crate::detections::{pooled_phases, recordings_table, scores_table as scores_of_many};
use crate::figures::{self, Shade};
use crate::pictures::page_detection;
use trocar_document::show;
use trocar_metrics::Unit;
use trocar_studies::detect::{Detection, DetectionReport};

/// Maximum number of alarms with a button.
const MAX_WINDOWS: usize = 6;

/// Maximum number of recordings on the timeline.
const MAX_LANES: usize = 120;

/// A detection in a recording.
#[derive(Clone, Copy, Debug)]
pub struct DetectionPage<'a> {
    /// The recording's name.
    pub name: &'a str,
    /// The estimates and decisions.
    pub detection: &'a Detection,
    /// The report about them.
    pub report: &'a DetectionReport,
    /// The threshold of the decision function, and its unit.
    pub scale: (f64, &'static str),
    /// The settings as TOML.
    pub settings: &'a str,
    /// The command that reproduces it.
    pub line: &'a str,
}

/// Returns the page of a detection.
///
/// # Errors
/// [`HtmlError`].
pub fn detection_html(page: &DetectionPage<'_>) -> Result<String, HtmlError> {
    let report = page.report;
    let mut numbers = vec![
        Block::table("Estimates by phase", &phases_table(&report.phases)),
        Block::table("Residual: measured minus estimated force", &residual_table(report)),
    ];
    if let Some(scores) = &report.scores {
        numbers.push(Block::table("Alarms compared with the labels", &scores_table(scores, report.window_s)));
    }
    numbers.push(Block::text(MEANINGS));
    let lane = lane_events(page.name, report, report.start_s);
    let (from_s, to_s) = (report.start_s, report.start_s + report.duration_s);
    let mut events = vec![Block::Timeline(Timeline::of(&[lane], (from_s, to_s), "labelled rupture"))];
    events.push(if report.alarms.is_empty() && report.missed().next().is_none() {
        Block::text("No alarm.")
    } else {
        Block::table("Alarms and missed ruptures", &events_table(&[(None, report)]))
    });
    let mut drawn = Drawn::default();
    let mut figures = page_detection(page.name, page.detection, report, page.scale)?;
    drawn.figures.insert("residual", figures.split_off(figures.len() - 1));
    drawn.figures.insert("signals", figures);
    let signals = vec![
        Block::Figures { name: "signals", windows: windows(report) },
        Block::text(
            "Long records are reduced to the minimum and maximum of short intervals; nearly every sample around ruptures and \
             alarms is kept. detection.csv has every sample.",
        ),
    ];
    let residual = vec![Block::figures("residual")];
    let settings = Block::File { name: format!("{}.toml", page.name), text: without_paths(page.settings) };
    let touched = (!report.touched).then(|| {
        "The needle never passes the contact position. Set it with --contact-m, or change the sign of the position."
            .to_owned()
    });
    let samples = format!(
        "{} samples over {}, {} apart, {} of them in contact; {} alarm{}.",
        report.samples,
        events::seconds(report.duration_s),
        show(Some(report.interval_s), Unit::Second),
        events::seconds(report.contact_s),
        report.alarms.len(),
        if report.alarms.len() == 1 { "" } else { "s" },
    );
    Page {
        command: "trocar detect",
        heading: page.name.to_owned(),
        lead: [samples].into_iter().chain(touched).chain(warned(&page.report.warnings)).collect(),
        sections: vec![
            Section { id: "metrics", title: "Results", blocks: numbers },
            Section { id: "events", title: "Events", blocks: events },
            Section { id: "signals", title: "Signals", blocks: signals },
            Section { id: "residual", title: "Distribution of the residual", blocks: residual },
            Section { id: "scenario", title: "Settings", blocks: vec![settings] },
            reproduction(page.line),
        ],
        drawn,
    }
    .render()
}

const MEANINGS: &str = "The residual e is the measured minus the estimated force. σ is its standard deviation. The robust σ is 1.4826 \
     times its median absolute deviation, which ruptures hardly change. K and B are the means of the \
     estimated stiffness and damping, s.e. is the mean of their standard error: a B within two of them of 0, as in a hold, is not \
     known. The phase is free without contact; the mean speed of the needle distinguishes insertion, hold and withdrawal. Precision is the \
     share of alarms that match a rupture, recall is the share of ruptures with a matching alarm, and F1 is their harmonic mean. \
     A delay is the time from a rupture to its alarm.";

/// Returns the page of detections in many recordings.
///
/// # Errors
/// [`HtmlError`].
pub fn detections_html(entries: &[DetectionEntry], line: &str) -> Result<String, HtmlError> {
    let reports: Vec<(&str, &DetectionReport)> =
        entries.iter().filter_map(|entry| Some((entry.name.as_str(), entry.report()?))).collect();
    let mut numbers = vec![Block::table("Recordings", &recordings_table(entries))];
    if let Some(scores) = scores_of_many(entries) {
        numbers.push(Block::table("Alarms compared with the labels", &scores));
    }
    numbers.push(Block::table("Estimates by phase, all recordings", &phases_table(&pooled_phases(entries))));
    numbers.push(Block::text(MEANINGS));
    let lanes: Vec<LaneEvents> =
        reports.iter().take(MAX_LANES).map(|(name, report)| lane_events(name, report, 0.0)).collect();
    let longest_s = reports.iter().map(|(_, report)| report.duration_s).fold(0.0, f64::max);
    let named: Vec<_> = reports.iter().map(|(name, report)| (Some(*name), *report)).collect();
    let mut events = vec![Block::Timeline(Timeline::of(&lanes, (0.0, longest_s), "labelled rupture"))];
    if reports.len() > MAX_LANES {
        events.push(Block::text(format!("The timeline shows the first {MAX_LANES} of {} recordings.", reports.len())));
    }
    events.push(Block::table("Alarms and missed ruptures", &events_table(&named)));
    let mut sections = vec![
        Section { id: "metrics", title: "Results", blocks: numbers },
        Section { id: "events", title: "Events", blocks: events },
    ];
    let delays_s: Vec<f64> =
        reports.iter().flat_map(|(_, report)| &report.alarms).filter_map(|alarm| alarm.delay_s).collect();
    let mut drawn = Drawn::default();
    if !delays_s.is_empty() {
        drawn.figures.insert("delays", vec![figures::delay_histogram(&delays_s)?.for_page(delays_s.len())]);
        let blocks = vec![Block::figures("delays")];
        sections.push(Section { id: "delays", title: "Detection delays", blocks });
    }
    let failed = entries.len() - reports.len();
    let unreadable = (failed > 0).then(|| format!("{failed} of {} recordings cannot be read.", entries.len()));
    sections.push(reproduction(line));
    Page {
        command: "trocar detect",
        heading: format!("{} recordings", reports.len()),
        lead: ["Each recording has its own page in the folder with its name.".to_owned()]
            .into_iter()
            .chain(unreadable)
            .collect(),
        sections,
        drawn,
    }
    .render()
}

fn reproduction(line: &str) -> Section {
    let note = "Run this command in the folder of the recordings.".to_owned();
    Section { id: "again", title: "Reproduce", blocks: vec![Block::Command { line: line.to_owned(), note }] }
}

/// Returns the phases, ruptures and alarms of a recording. The first sample is at `start_s`.
fn lane_events(name: &str, report: &DetectionReport, start_s: f64) -> LaneEvents {
    let at = |time_s: f64| start_s + time_s - report.start_s;
    let ruptures = report.labelled_ruptures_s.iter().enumerate().map(|(index, time_s)| Mark {
        at_s: at(*time_s),
        kind: "rupture",
        label: report.labelled_kinds[index].clone().unwrap_or_else(|| format!("rupture {}", index + 1)),
        fate: report
            .misses
            .iter()
            .find(|missed| missed.label == index)
            .map_or("detected".to_owned(), |missed| format!("missed: {}", missed.miss)),
    });
    let alarms = report.alarms.iter().map(|alarm| Mark {
        at_s: at(alarm.time_s),
        kind: "alarm",
        label: "alarm".into(),
        fate: String::new(),
    });
    let of = |sample: usize| start_s + sample as f64 * report.interval_s;
    let intervals = report.intervals.iter();
    let shades = intervals.filter_map(|s| Some((of(s.samples.start), of(s.samples.end), Shade::of_phase(s.phase)?)));
    LaneEvents { name: name.to_owned(), shades: shades.collect(), marks: ruptures.chain(alarms).collect() }
}

fn windows(report: &DetectionReport) -> Vec<Window> {
    let window = |label: String, at: f64| Window { label, from: (at - 0.1).max(report.start_s), to: at + 0.4 };
    let alarms = report.alarms.iter().enumerate();
    alarms.take(MAX_WINDOWS).map(|(index, alarm)| window(format!("alarm {}", index + 1), alarm.time_s)).collect()
}
