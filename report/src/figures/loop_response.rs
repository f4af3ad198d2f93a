//! The loop gain over frequency, and the step of the feedback force.

use super::axis::{Axis, Y_TICKS, extent};
use super::grid::{Grid, Row, Sample};
use super::panel::{Panel, Trace};
use super::style::{RUNS, THRESHOLD};
use super::{Figure, FigureError};

/// Lower limit of the magnitudes that are drawn, and the range of the Nyquist diagram.
const MIN_MAGNITUDE: f64 = 1e-4;
const NYQUIST: f64 = 1.6;

/// Columns over frequency, and over time.
#[derive(Clone, Debug)]
pub struct LoopView {
    /// Hz, increasing.
    pub frequency_hz: Vec<f64>,
    /// `|L|`.
    pub magnitude: Vec<f64>,
    /// Its phase in degrees.
    pub phase_deg: Vec<f64>,
    /// Its real part.
    pub real: Vec<f64>,
    /// Its imaginary part.
    pub imaginary: Vec<f64>,
    /// The gain margin, and its frequency in Hz.
    pub gain_margin: Option<(f64, f64)>,
    /// The frequency of the phase margin in Hz.
    pub phase_margin_hz: Option<f64>,
    /// s; empty without a step response.
    pub time_s: Vec<f64>,
    /// Feedback force per metre of desired position, in N/m.
    pub force: Vec<f64>,
}

/// Draws the loop gain as Bode and Nyquist diagrams, and the step of the feedback force.
///
/// # Errors
/// [`FigureError::Empty`] without frequencies, [`FigureError::Length`] for columns of unequal lengths.
pub fn loop_response(view: &LoopView) -> Result<Figure, FigureError> {
    let columns = [
        ("magnitude", view.magnitude.len()),
        ("phase_deg", view.phase_deg.len()),
        ("real", view.real.len()),
        ("imaginary", view.imaginary.len()),
    ];
    super::check("loop", "loop", view.frequency_hz.len(), &columns)?;
    super::check("loop", "step", view.time_s.len(), &[("force", view.force.len())])?;
    let Some((low, high)) = extent(view.frequency_hz.iter().copied()) else {
        return Err(FigureError::Empty { figure: "loop" });
    };
    let x_axis = Axis::log10((low, high));
    let x: Vec<f64> = view.frequency_hz.iter().map(|frequency| x_axis.place(*frequency)).collect();
    let (min, max) = extent(view.magnitude.iter().copied().filter(|value| *value > 0.0)).unwrap_or((0.1, 1.0));
    let of_magnitude = Axis::log10((min.max(MIN_MAGNITUDE) / 1.5, 1.5 * max.max(1.0)));
    let shown: Vec<f64> = view.magnitude.iter().map(|value| value.max(MIN_MAGNITUDE)).collect();
    let [blue, vermilion] = [RUNS[0], RUNS[1]];
    let of_gain = view
        .gain_margin
        .map(|(margin, hertz)| (vec![(x_axis.place(hertz), of_magnitude.place(1.0 / margin))], vermilion));
    let at_phase = view.phase_margin_hz.and_then(|hertz| {
        let next = view.frequency_hz.iter().position(|frequency| *frequency >= hertz)?;
        let (from, to) = (next.saturating_sub(1), next);
        let share = if to > from { (x_axis.place(hertz) - x[from]) / (x[to] - x[from]) } else { 0.0 };
        let phase = view.phase_deg[from] + share * (view.phase_deg[to] - view.phase_deg[from]);
        Some((x_axis.place(hertz), phase))
    });
    let of_phase = at_phase.map(|(place, _)| (vec![(place, of_magnitude.place(1.0))], vermilion));
    let marks = of_gain.into_iter().chain(of_phase).collect();
    let phase_mark = at_phase.map(|point| (vec![point], vermilion));
    let on_circle = at_phase.map(|(_, phase)| {
        let (im, re) = phase.to_radians().sin_cos();
        (vec![(re, im)], vermilion)
    });
    let bode = Panel {
        x_caption: "Frequency (Hz)",
        traces: vec![Trace { x: &x, y: &shown, scale: 1.0, stroke: blue }],
        levels: vec![(1.0, THRESHOLD)],
        curves: marks,
        ..Panel::over_time(x_axis.clone(), of_magnitude, "|L|")
    };
    let phase = extent(view.phase_deg.iter().copied()).unwrap_or((-180.0, 0.0));
    let phase = Panel {
        x_caption: "Frequency (Hz)",
        traces: vec![Trace { x: &x, y: &view.phase_deg, scale: 1.0, stroke: blue }],
        curves: phase_mark.into_iter().collect(),
        ..Panel::over_time(x_axis, Axis::padded(phase, Y_TICKS), "Phase of L (°)")
    };
    let limit = |values: &[f64]| -> Vec<f64> { values.iter().map(|value| value.clamp(-NYQUIST, NYQUIST)).collect() };
    let (re, im) = (limit(&view.real), limit(&view.imaginary));
    let square = || Axis::exact((-NYQUIST, NYQUIST), Y_TICKS);
    let nyquist = Panel {
        x_caption: "Re L",
        traces: vec![Trace { x: &re, y: &im, scale: 1.0, stroke: blue }],
        curves: std::iter::once((vec![(1.0, 0.0)], vermilion)).chain(on_circle).collect(),
        ..Panel::over_time(square(), square(), "Im L")
    };
    let row = |height, panel| Row { title: None, height, panels: vec![panel] };
    let mut rows = vec![row(330.0, bode), row(260.0, phase), row(460.0, nyquist)];
    if let Some(end) = view.time_s.last().filter(|end| **end > 0.0) {
        let force = extent(view.force.iter().copied()).unwrap_or((0.0, 1.0));
        let step = Panel {
            x_caption: "Time (s)",
            traces: vec![Trace { x: &view.time_s, y: &view.force, scale: 1.0, stroke: blue }],
            ..Panel::over_time(Axis::exact((0.0, *end), Y_TICKS), Axis::padded(force, Y_TICKS), "Force per step (N/m)")
        };
        rows.push(row(300.0, step));
    }
    let legend = vec![
        (Sample::Line(blue), "loop gain; feedback force after a step of the desired position".to_owned()),
        (Sample::Line(vermilion), "gain and phase margin; the critical point".to_owned()),
        (Sample::Line(THRESHOLD), "gain of 1".to_owned()),
    ];
    Grid { legends: vec![legend], common: vec![], rows }.draw()
}
