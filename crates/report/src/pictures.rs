//! The figures of a run, a comparison and a detection, and their files.

use rayon::prelude::*;
use serde_json::Value as Json;
use thiserror::Error;

use super::{Folder, OutputError};
use crate::draw::{DrawError, file};
use trocar_detect::{Detection, DetectionReport};
use trocar_document::Figure;
use trocar_engine::engine::TrustColumns;
use trocar_figures::{self as figures, EstimationView, FigureError, RunView, TimelineRow};

/// The error of drawing or writing figures.
#[derive(Debug, Error)]
pub enum PictureError {
    /// A figure could not be described.
    #[error(transparent)]
    Describe(#[from] FigureError),
    /// A figure could not be drawn.
    #[error(transparent)]
    Draw(#[from] DrawError),
    /// A file could not be written.
    #[error(transparent)]
    Write(#[from] OutputError),
    /// The page of figures could not be rendered.
    #[error("cannot render the page: {0}")]
    Page(#[source] minijinja::Error),
}

pub(super) type Job<'a> = (&'static str, Box<dyn Fn() -> Result<Figure<'a>, FigureError> + Send + Sync + 'a>);

/// Draws figures in parallel and writes the files of each.
pub(super) fn draw(folder: &Folder, jobs: Vec<Job<'_>>) -> Result<(), PictureError> {
    jobs.into_par_iter().try_for_each(|(name, job)| keep(folder, name, &job()?))
}

/// Writes the files of a figure: one for each format of the folder's style.
pub(super) fn keep(folder: &Folder, name: &str, figure: &Figure<'_>) -> Result<(), PictureError> {
    let style = folder.figures();
    style.formats.par_iter().try_for_each(|format| {
        let file = file(figure, *format, style.width)?;
        Ok(folder.write(&format!("{name}.{}", format.word()), &file)?)
    })
}

/// Number of intervals of all runs on a page together, which keeps it below 2 MB.
const PAGE_INTERVALS: usize = 1_300;

/// Describes the figures of an estimation over time.
fn page_estimation(view: &EstimationView<'_>, intervals: usize) -> Result<Vec<Json>, FigureError> {
    let draw = [figures::estimation, figures::parameters, figures::decision];
    draw.into_iter().map(|draw: figures::DrawEstimation| Ok(draw(view)?.for_page(intervals))).collect()
}

/// Describes the figures of a detection for a page. The last one is not over time.
///
/// # Errors
/// [`FigureError`].
pub(super) fn page_detection(
    name: &str,
    detection: &Detection,
    report: &DetectionReport,
    scale: (f64, &'static str),
) -> Result<Vec<Json>, FigureError> {
    let alarms_s: Vec<f64> = report.alarms.iter().map(|alarm| alarm.time_s).collect();
    let trust = detection.trust();
    let view = of_detection(name, (detection, &trust), (report, &alarms_s), scale);
    let mut figures = page_estimation(&view, PAGE_INTERVALS / 2)?;
    figures.push(figures::residual_histogram(&view)?.for_page(PAGE_INTERVALS));
    Ok(figures)
}

/// Describes the figure of the forces and positions of a run without its signals, which a page adds.
///
/// # Errors
/// [`FigureError`].
pub fn teleoperation_axes(is_augmented: bool) -> Result<Json, FigureError> {
    let zero: &[f64] = &[0.0];
    let view = RunView {
        name: "",
        is_augmented,
        time_s: zero,
        master_position_m: zero,
        slave_position_m: zero,
        operator_force_n: zero,
        tissue_force_n: zero,
        feedback_force_n: zero,
        mode: &[0],
        rupture_times_s: vec![].into(),
        alarm_times_s: vec![].into(),
    };
    Ok(figures::comparison(&[view], None)?.for_page(1))
}

fn as_slice<'a>(named: &'a Option<(&'static str, Vec<f64>)>) -> Option<(&'static str, &'a [f64])> {
    named.as_ref().map(|(name, column)| (*name, column.as_slice()))
}

fn shown_unit(unit: &'static str) -> &'static str {
    if unit == "1" { "" } else { unit }
}

fn estimation_jobs<'a>(view: EstimationView<'a>) -> Vec<Job<'a>> {
    let job = |(name, describe): (&'static str, figures::DrawEstimation)| -> Job<'a> {
        let view = view.clone();
        (name, Box::new(move || describe(&view)))
    };
    figures::ESTIMATION_FIGURES.map(job).into()
}

/// Writes a detection's figures: `estimation`, `parameters`, `decision`, `residual`.
///
/// # Errors
/// [`PictureError`].
pub fn detection_pictures(
    folder: &Folder,
    name: &str,
    detection: &Detection,
    report: &DetectionReport,
    scale: (f64, &'static str),
) -> Result<(), PictureError> {
    let alarms_s: Vec<f64> = report.alarms.iter().map(|alarm| alarm.time_s).collect();
    let trust = detection.trust();
    draw(folder, estimation_jobs(of_detection(name, (detection, &trust), (report, &alarms_s), scale)))
}

fn of_detection<'a>(
    name: &'a str,
    (detection, trust): (&'a Detection, &'a TrustColumns),
    (report, alarms_s): (&'a DetectionReport, &'a [f64]),
    (threshold, unit): (f64, &'static str),
) -> EstimationView<'a> {
    EstimationView {
        name,
        time_s: &detection.time_s,
        measured_force_n: &detection.measured_force_n,
        residual_n: &detection.residual_n,
        stiffness_n_per_m: &detection.stiffness_n_per_m,
        damping_n_s_per_m: &detection.damping_n_s_per_m,
        standard_errors: Some([(&*trust.stiffness_std_n_per_m).into(), (&*trust.damping_std_n_s_per_m).into()]),
        extra_parameter: as_slice(&detection.extra_parameter),
        decision: &detection.decision,
        threshold,
        decision_unit: shown_unit(unit),
        rupture_times_s: (&*report.labelled_ruptures_s).into(),
        alarm_times_s: alarms_s.into(),
    }
}

/// Writes the figures of many recordings: `timeline`, a row per recording with its phases, ruptures and alarms (of the first
/// [`MAX_ROWS`](figures::MAX_ROWS)), and `delays`, the distribution of the detection delays, if any alarm matches a label.
///
/// # Errors
/// [`PictureError`].
pub fn detections_pictures(folder: &Folder, reports: &[(&str, &DetectionReport)]) -> Result<(), PictureError> {
    if reports.is_empty() {
        return Ok(());
    }
    let mut jobs: Vec<Job<'_>> = vec![(
        "timeline",
        Box::new(|| {
            let shown = &reports[..reports.len().min(figures::MAX_ROWS)];
            figures::timeline(&shown.iter().map(|(name, report)| timeline_row(name, report)).collect::<Vec<_>>())
        }),
    )];
    let delays_s: Vec<f64> =
        reports.iter().flat_map(|(_, report)| &report.alarms).filter_map(|alarm| alarm.delay_s).collect();
    if !delays_s.is_empty() {
        jobs.push(("delays", Box::new(move || figures::delay_histogram(&delays_s))));
    }
    draw(folder, jobs)
}

fn timeline_row<'a>(name: &'a str, report: &DetectionReport) -> TimelineRow<'a> {
    let at = |sample: usize| sample as f64 * report.interval_s;
    let intervals = report.intervals.iter();
    TimelineRow {
        name,
        duration_s: report.duration_s,
        shades: intervals.filter_map(|s| Some((at(s.samples.start), at(s.samples.end), s.phase.shade()?))).collect(),
        rupture_times_s: report.labelled_ruptures_s.iter().map(|time| time - report.start_s).collect(),
        alarm_times_s: report.alarms.iter().map(|alarm| alarm.time_s - report.start_s).collect(),
    }
}
