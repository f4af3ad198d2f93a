//! The pages of detections in one recording and in many.

use super::chart::{Chart, ChartAxis, ChartShade, Columns, Extras, Mark, Series};
use super::compared::without_paths;
use super::events::{self, LaneEvents, Timeline};
use super::page::{Block, Drawn, HtmlError, Page, Section, Window, warned};
use super::signals::{
    PARAMETERS, bounded, decision_unit, estimate, extra_parameter_axis, intervals_per_run, thresholded,
};
use crate::DetectionEntry;
use crate::decimate::kept;
use crate::detection::{events_table, phases_table, residual_table, scores_table};
use crate::detections::{pooled_phases, recordings_table, scores_table as scores_of_many};
use crate::digits::Fine;
use crate::figures::{self, Histogram};
use crate::number::{show, significant};
use trocar_sim::detect::{Detection, DetectionReport, Phase};
use trocar_sim::metrics::Unit;

/// Maximum number of alarms with a button.
const MAX_WINDOWS: usize = 6;

/// Maximum number of recordings on the timeline.
const MAX_LANES: usize = 120;

/// Number of segments of the Gaussian's curve.
const CURVE: i32 = 120;

const KEY: [(&str, &str); 5] = [
    ("rupture", "labelled rupture"),
    ("alarm", "alarm"),
    ("insertion", "insertion"),
    ("hold", "hold"),
    ("withdrawal", "withdrawal"),
];

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
    let mut events = vec![Block::Timeline(Timeline::of(&[lane], (from_s, to_s), KEY.to_vec()))];
    events.push(if report.alarms.is_empty() && report.missed().next().is_none() {
        Block::text("No alarm.")
    } else {
        Block::table("Alarms and missed ruptures", &events_table(&[(None, report)]))
    });
    let mut drawn = Drawn::default();
    drawn.charts.insert("signals", charts(page));
    drawn.charts.insert("residual", vec![residual(&page.detection.residual_n)]);
    let signals = vec![
        Block::Charts { name: "signals", windows: windows(report), key: KEY.to_vec() },
        Block::text(
            "Long records are reduced to the minimum and maximum of short intervals; nearly every sample around ruptures and \
             alarms is kept. detection.csv has every sample.",
        ),
    ];
    let residual = vec![Block::Charts { name: "residual", windows: vec![], key: vec![] }];
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
    let mut events = vec![Block::Timeline(Timeline::of(&lanes, (0.0, longest_s), KEY.to_vec()))];
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
    if let Some(delays) = delays(&delays_s) {
        drawn.charts.insert("delays", vec![delays]);
        let blocks = vec![Block::Charts { name: "delays", windows: vec![], key: vec![] }];
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
    let at = |time_s: f64| Fine(start_s + time_s - report.start_s);
    let ruptures = report.labelled_ruptures_s.iter().enumerate().map(|(index, time_s)| Mark {
        at: at(*time_s),
        kind: "rupture",
        label: report.labelled_kinds[index].clone().unwrap_or_else(|| format!("rupture {}", index + 1)),
        fate: report
            .misses
            .iter()
            .find(|missed| missed.label == index)
            .map_or("detected".to_owned(), |missed| format!("missed: {}", missed.miss)),
    });
    let alarms = report.alarms.iter().map(|alarm| Mark {
        at: at(alarm.time_s),
        kind: "alarm",
        label: "alarm".into(),
        fate: String::new(),
    });
    let shade = |interval: &trocar_sim::detect::PhaseInterval| {
        let name = match interval.phase {
            Phase::Free => return None,
            Phase::Insertion => "insertion",
            Phase::Hold => "hold",
            Phase::Withdrawal => "withdrawal",
        };
        let of = |sample: usize| Fine(start_s + sample as f64 * report.interval_s);
        Some(ChartShade { from: of(interval.samples.start), to: of(interval.samples.end), name })
    };
    LaneEvents {
        name: name.to_owned(),
        shades: report.intervals.iter().filter_map(shade).collect(),
        marks: ruptures.chain(alarms).collect(),
    }
}

fn windows(report: &DetectionReport) -> Vec<Window> {
    let window = |label: String, at: f64| Window { label, from: (at - 0.1).max(report.start_s), to: at + 0.4 };
    let alarms = report.alarms.iter().enumerate();
    alarms.take(MAX_WINDOWS).map(|(index, alarm)| window(format!("alarm {}", index + 1), alarm.time_s)).collect()
}

fn charts(page: &DetectionPage<'_>) -> Vec<Chart> {
    let detection = page.detection;
    let events = lane_events(page.name, page.report, page.report.start_s);
    let detailed = events::detailed_intervals(&events.marks);
    let unlabelled = |mark: Mark| if mark.kind == "alarm" { Mark { label: String::new(), ..mark } } else { mark };
    let marks = events.marks.into_iter().map(unlabelled).collect();
    let extras = Extras { shades: events.shades, marks, thresholds: vec![] };
    let chart = |title: &str, (label, unit): (&str, &'static str), lines: Vec<(Series, &[f64])>| {
        let (series, columns): (Vec<_>, Vec<_>) = lines.into_iter().unzip();
        let rows = kept(&detection.time_s, &columns, &detailed, intervals_per_run(1));
        let columns = vec![Columns::rows(&detection.time_s, &columns, &rows, 1.0)];
        let axes = (ChartAxis::new("time", "s"), ChartAxis::new(label, unit));
        Chart { series, columns, extras: extras.clone(), ..Chart::new(title, axes.0, axes.1) }
    };
    let line = |label: &str| Series::line(label, "blue");
    let pairs = detection.measured_force_n.iter().zip(&detection.residual_n);
    let estimated: Vec<f64> = pairs.map(|(measured, residual)| measured - residual).collect();
    let forces = vec![
        (Series { width: 4.0, ..Series::line("measured", "sky") }, detection.measured_force_n.as_slice()),
        (Series::line("estimated", "vermilion"), estimated.as_slice()),
    ];
    let mut charts = vec![
        Chart { mark_labels: true, height: 280, ..chart("Measured and estimated force", ("force", "N"), forces) },
        chart(
            "Residual: measured minus estimated force",
            ("residual", "N"),
            vec![(line("residual"), &detection.residual_n)],
        ),
    ];
    let trust = detection.trust();
    let [stiffness, damping] = PARAMETERS.map(|(title, y)| chart(title, y, vec![]));
    let estimated = [
        (stiffness, &detection.stiffness_n_per_m, &trust.stiffness_std_n_per_m),
        (damping, &detection.damping_n_s_per_m, &trust.damping_std_n_s_per_m),
    ];
    charts.extend(
        estimated.map(|(chart, y, std)| {
            estimate(Chart { columns: vec![], ..chart }, &detection.time_s, (y, std), &detailed)
        }),
    );
    if let Some((name, column)) = &detection.extra_parameter {
        let (title, y) = extra_parameter_axis(name);
        charts.push(bounded(chart(title, y, vec![(line(y.0), column)]), 0.995));
    }
    let y = ("decision", decision_unit(page.scale.1));
    let decision = chart("Decision function and its threshold", y, vec![(line("decision"), &detection.decision)]);
    charts.push(thresholded(decision, &[page.scale.0]));
    charts.into_iter().map(Chart::described).collect()
}

/// Returns the density of the residual, with the Gaussian of its robust standard deviation.
fn residual(residual_n: &[f64]) -> Chart {
    let (residuals, Histogram { half, bin, densities, sigma }) = figures::histogram(residual_n);
    let min_density = 0.5 / (residuals.len().max(1) as f64 * bin);
    let left = (0..=densities.len()).map(|k| -half + bin * k as f64);
    let last = densities.last().copied();
    // A logarithmic axis cannot show a density of 0, so an empty bin has no value.
    let shown = densities.into_iter().chain(last).map(|density| if density > 0.0 { density } else { f64::NAN });
    let (x, y) = (ChartAxis::new("residual", "N"), ChartAxis::new("density", "1/N").log());
    let mut chart = Chart { height: 300, ..Chart::new("Density of the residual", x, y) };
    let samples = format!("{} samples", residuals.len());
    chart.series.push(Series { stepped: true, ..Series::line(samples, "blue") });
    chart.columns.push(Columns::new(left, vec![shown.collect()]));
    if let Some(sigma) = sigma {
        let at = |k: i32| -half + 2.0 * half * f64::from(k) / f64::from(CURVE);
        let curve =
            (0..=CURVE).map(|k| figures::gaussian(at(k), sigma)).map(|p| if p < min_density { f64::NAN } else { p });
        chart.series.push(Series::line(format!("Gaussian, σ = {} N", significant(sigma)), "vermilion").dashed());
        chart.columns.push(Columns::new((0..=CURVE).map(at), vec![curve.collect()]));
    }
    chart.described()
}

/// Returns the histogram of the delays, or `None` without a delay.
fn delays(delays_s: &[f64]) -> Option<Chart> {
    let delays_ms: Vec<f64> = delays_s.iter().map(|delay| 1e3 * delay).collect();
    let max_ms = delays_ms.iter().copied().reduce(f64::max)?;
    let (counts, bin) = figures::bins(&delays_ms, max_ms);
    let ends = (0..=counts.len()).map(|k| bin * k as f64);
    let steps = counts.iter().chain(counts.last()).map(|count| *count as f64).collect();
    let (x, y) = (ChartAxis::new("delay", "ms"), ChartAxis::new("alarms", ""));
    let mut chart = Chart::new("Alarms by their delay after the rupture", x, y);
    chart.series.push(Series { stepped: true, ..Series::line("alarms", "blue") });
    chart.columns.push(Columns::new(ends, vec![steps]));
    chart.includes = vec![crate::digits::Few(0.0)];
    Some(chart.described())
}
