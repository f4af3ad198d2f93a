//! The figures of a run and a comparison, and their files.

use std::ops::Range;
use std::sync::OnceLock;

use rayon::prelude::*;
use serde_json::Value as Json;
use thiserror::Error;

use super::{Animation, Folder, OutputError};
use crate::draw::{DrawError, FigureFormat, FigureWidth, file};
use trocar_document::Figure;
use trocar_engine::engine::TrustColumns;
use trocar_figures::{self as figures, EnergyView, EstimationView, FigureError, RunView};
use trocar_studies::run::Run;

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

/// A run and the times of its ruptures and alarms.
pub(super) struct DrawnRun<'a> {
    run: &'a Run,
    ruptures_s: Vec<f64>,
    alarms_s: Vec<f64>,
    /// Computed for the first figure that shows it.
    trust: OnceLock<Option<TrustColumns>>,
}

impl<'a> DrawnRun<'a> {
    pub(super) fn of(run: &'a Run) -> Self {
        Self {
            run,
            ruptures_s: run.metrics.ruptures.iter().map(|rupture| rupture.time_s).collect(),
            alarms_s: run.metrics.alarms.iter().map(|alarm| alarm.time_s).collect(),
            trust: OnceLock::new(),
        }
    }

    pub(super) fn view(&self) -> RunView<'_> {
        let trace = &self.run.trace;
        RunView {
            name: &self.run.scenario.name,
            is_augmented: self.run.scenario.augmentation.enabled,
            time_s: &trace.time_s,
            master_position_m: &trace.master_position_m,
            slave_position_m: &trace.slave_position_m,
            operator_force_n: &trace.operator_force_n,
            tissue_force_n: &trace.tissue_force_n,
            feedback_force_n: &trace.feedback_force_n,
            mode: &trace.mode,
            rupture_times_s: &self.ruptures_s,
            alarm_times_s: &self.alarms_s,
        }
    }

    pub(super) fn estimation(&self) -> EstimationView<'_> {
        let trace = &self.run.trace;
        let detector = &self.run.scenario.detector;
        EstimationView {
            name: &self.run.scenario.name,
            time_s: &trace.time_s,
            measured_force_n: &trace.measured_force_n,
            residual_n: &trace.residual_n,
            stiffness_n_per_m: &trace.stiffness_n_per_m,
            damping_n_s_per_m: &trace.damping_n_s_per_m,
            standard_errors: self
                .trust
                .get_or_init(|| trace.trust())
                .as_ref()
                .map(|trust| [&*trust.stiffness_std_n_per_m, &*trust.damping_std_n_s_per_m]),
            extra_parameter: as_slice(&trace.extra_parameter),
            decision: &trace.decision,
            threshold: detector.cusum.threshold,
            decision_unit: detector.distance.kind.unit(),
            rupture_times_s: &self.ruptures_s,
            alarm_times_s: &self.alarms_s,
        }
    }
}

/// Number of intervals of all runs on a page together, which keeps it below 2 MB.
const PAGE_INTERVALS: usize = 1_300;

/// Describes the signals of runs for a page: those of several runs in the same axes, and the figures of a single run.
///
/// # Errors
/// [`FigureError`].
pub(super) fn page_signals(runs: &[&Run]) -> Result<Vec<Json>, FigureError> {
    let intervals = PAGE_INTERVALS / runs.len().max(2);
    let borrowed: Vec<_> = runs.iter().filter(|run| !run.trace.is_empty()).map(|run| DrawnRun::of(run)).collect();
    let ends = borrowed.iter().filter_map(|run| run.run.trace.time_s.last().copied());
    let whole = (0.0, ends.fold(0.0, f64::max));
    match borrowed.as_slice() {
        [] => Ok(vec![]),
        [run] => {
            let teleoperation = figures::comparison(&[run.view()], Some(whole))?.for_page(intervals);
            let estimation = page_estimation(&run.estimation(), intervals)?;
            Ok(std::iter::once(teleoperation).chain(estimation).collect())
        }
        runs => {
            let views: Vec<_> = runs.iter().map(|run| (run.view(), run.estimation())).collect();
            Ok(vec![figures::signals(&views, whole)?.for_page(intervals)])
        }
    }
}

/// Describes the figures of an estimation over time.
fn page_estimation(view: &EstimationView<'_>, intervals: usize) -> Result<Vec<Json>, FigureError> {
    let draw = [figures::estimation, figures::parameters, figures::decision];
    draw.into_iter().map(|draw: figures::DrawEstimation| Ok(draw(view)?.for_page(intervals))).collect()
}

/// Describes the signals of runs at some ticks for a page that shows them live, with the points apart in `bytes`, as 32-bit floats,
/// little endian.
///
/// # Errors
/// [`FigureError`] if no run has any of the ticks.
pub fn live_signals(
    runs: &[Run],
    ticks: Range<usize>,
    intervals: usize,
    bytes: &mut Vec<u8>,
) -> Result<Json, FigureError> {
    let borrowed: Vec<_> = runs.iter().map(DrawnRun::of).collect();
    let views: Vec<_> = borrowed.iter().map(|run| (run.view().at(&ticks), run.estimation().at(&ticks))).collect();
    let times_s = views.iter().flat_map(|(run, _)| run.time_s.first().into_iter().chain(run.time_s.last())).copied();
    let window = times_s.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), at| (low.min(at), high.max(at)));
    Ok(figures::signals(&views, window)?.for_frame(intervals, bytes))
}

/// Draws the forces and positions of a run in a window of time (s) as PNG.
///
/// # Errors
/// [`PictureError`].
pub fn run_png(run: &Run, window: (f64, f64), width: FigureWidth) -> Result<Vec<u8>, PictureError> {
    Ok(file(&figures::comparison(&[DrawnRun::of(run).view()], Some(window))?, FigureFormat::Png, width)?)
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
        rupture_times_s: &[],
        alarm_times_s: &[],
    };
    Ok(figures::comparison(&[view], None)?.for_page(1))
}

fn as_slice<'a>(named: &'a Option<(&'static str, Vec<f64>)>) -> Option<(&'static str, &'a [f64])> {
    named.as_ref().map(|(name, column)| (*name, column.as_slice()))
}

fn estimation_jobs<'a>(view: EstimationView<'a>) -> Vec<Job<'a>> {
    let job =
        |(name, draw): (&'static str, figures::DrawEstimation)| -> Job<'a> { (name, Box::new(move || draw(&view))) };
    figures::ESTIMATION_FIGURES.map(job).into()
}

/// Writes a run's figures: `teleoperation`, `energy`, `estimation`, `parameters`, `decision`, `residual`. A run without ticks has no
/// figures.
///
/// # Errors
/// [`PictureError`].
pub fn run_pictures(folder: &Folder, run: &Run) -> Result<(), PictureError> {
    if run.trace.is_empty() {
        return Ok(());
    }
    let borrowed = DrawnRun::of(run);
    let mut jobs = estimation_jobs(borrowed.estimation());
    let view = borrowed.view();
    let range = run.trace.time_s.first().copied().zip(run.trace.time_s.last().copied());
    let energies = energies(run);
    jobs.push(("energy", Box::new(move || figures::energy(&energies))));
    jobs.push(("teleoperation", Box::new(move || figures::comparison(&[view], range))));
    draw(folder, jobs)
}

/// Writes a comparison's figures: `comparison` with one row of axes per run, `overlay` with all runs in the same axes, and
/// `animation.png`, the first two runs around their first rupture.
///
/// # Errors
/// [`PictureError`].
pub fn comparison_pictures(folder: &Folder, runs: &[Run]) -> Result<(), PictureError> {
    let borrowed: Vec<_> = runs.iter().filter(|run| !run.trace.is_empty()).map(DrawnRun::of).collect();
    if borrowed.is_empty() {
        return Ok(());
    }
    if let Some(animation) = Animation::of(&runs.iter().collect::<Vec<_>>()) {
        folder.write("animation.png", &animation.png()?)?;
    }
    let views: Vec<_> = borrowed.iter().map(DrawnRun::view).collect();
    let views = &views;
    draw(
        folder,
        vec![
            ("comparison", Box::new(move || figures::comparison(views, None))),
            ("overlay", Box::new(move || figures::overlay(views, None))),
        ],
    )
}

pub(crate) fn energies(run: &Run) -> EnergyView<'_> {
    let trace = &run.trace;
    EnergyView {
        name: &run.scenario.name,
        time_s: &trace.time_s,
        hand_energy_j: &trace.hand_energy_j,
        master_energy_j: &trace.master_energy_j,
        reference_energy_j: &trace.reference_energy_j,
        needle_energy_j: &trace.needle_energy_j,
        energy_scale: run.scenario.link.machines.energy_scale(),
        promised_energy_j: run.metrics.link.as_ref().and_then(|link| link.promised_energy_j),
    }
}
