//! The loop gain over frequency, and the step of the feedback force.

use super::FigureError;
use super::axis::{Axis, Y_TICKS, extent};
use super::figure::{Figure, Row};
use super::legend::Sample;
use super::panel::{Panel, Trace};
use super::style::{COMPUTED, LIMIT, PURPLE, Stroke};

/// Lower limit of the magnitudes that are drawn, and the range of the Nyquist diagram.
const MIN_MAGNITUDE: f64 = 1e-4;
const NYQUIST: f64 = 1.6;

/// Columns over frequency, and over time.
#[derive(Clone, Debug)]
pub struct LoopView {
    /// Name of the scenario.
    pub name: String,
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
pub fn loop_response(view: &LoopView) -> Result<Figure<'static>, FigureError> {
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
    let mark = Stroke::solid(PURPLE, 5.0);
    let of_gain =
        view.gain_margin.map(|(margin, hertz)| (vec![(x_axis.place(hertz), of_magnitude.place(1.0 / margin))], mark));
    let at_phase = view.phase_margin_hz.and_then(|hertz| {
        let next = view.frequency_hz.iter().position(|frequency| *frequency >= hertz)?;
        let (from, to) = (next.saturating_sub(1), next);
        let share = if to > from { (x_axis.place(hertz) - x[from]) / (x[to] - x[from]) } else { 0.0 };
        let phase = view.phase_deg[from] + share * (view.phase_deg[to] - view.phase_deg[from]);
        Some((x_axis.place(hertz), phase))
    });
    let of_phase = at_phase.map(|(place, _)| (vec![(place, of_magnitude.place(1.0))], mark));
    let marks = of_gain.into_iter().chain(of_phase).collect();
    let phase_mark = at_phase.map(|point| (vec![point], mark));
    let on_circle = at_phase.map(|(_, phase)| {
        let (im, re) = phase.to_radians().sin_cos();
        (vec![(re, im)], mark)
    });
    let trace = |x: &[f64], y: &[f64]| vec![Trace::new(x.to_vec(), y.to_vec(), COMPUTED)];
    let entry = |sample, text: &str| (sample, text.to_owned());
    let margins = match (view.gain_margin, at_phase) {
        (Some(_), Some(_)) => Some("gain and phase margin"),
        (Some(_), None) => Some("gain margin"),
        (None, Some(_)) => Some("phase margin"),
        (None, None) => None,
    };
    let margins = margins.map(|name| entry(Sample::Dot(mark), name));
    let of_phase_margin = at_phase.map(|_| entry(Sample::Dot(mark), "phase margin"));
    let bode = Panel {
        traces: trace(&x, &view.magnitude),
        levels: vec![(1.0, LIMIT)],
        curves: marks,
        legend: [entry(Sample::Line(COMPUTED), "loop gain L"), entry(Sample::Line(LIMIT), "gain of 1")]
            .into_iter()
            .chain(margins)
            .collect(),
        ..Panel::new(x_axis.clone(), "Frequency (Hz)", of_magnitude, "|L|")
    };
    let phase = extent(view.phase_deg.iter().copied()).unwrap_or((-180.0, 0.0));
    let phase = Panel {
        traces: trace(&x, &view.phase_deg),
        curves: phase_mark.into_iter().collect(),
        ..Panel::new(x_axis, "Frequency (Hz)", Axis::padded(phase, Y_TICKS), "Phase of L (°)")
    };
    let square = || Axis::exact((-NYQUIST, NYQUIST), Y_TICKS);
    // Not increasing over its axis, so a curve.
    let nyquist = view.real.iter().copied().zip(view.imaginary.iter().copied()).collect();
    let critical = Stroke::solid(PURPLE, 8.0);
    let nyquist = Panel {
        curves: [(nyquist, COMPUTED), (vec![(1.0, 0.0)], critical)].into_iter().chain(on_circle).collect(),
        legend: std::iter::once(entry(Sample::Dot(critical), "critical point")).chain(of_phase_margin).collect(),
        ..Panel::new(square(), "Re L", square(), "Im L")
    };
    let mut rows = vec![Row::of(100.0, bode), Row::of(80.0, phase)];
    let mut last = vec![nyquist];
    if let Some(end) = view.time_s.last().filter(|end| **end > 0.0) {
        let force = extent(view.force.iter().copied()).unwrap_or((0.0, 1.0));
        last.push(Panel {
            traces: trace(&view.time_s, &view.force),
            legend: vec![entry(Sample::Line(COMPUTED), "step of the desired position")],
            ..Panel::over_time(
                Axis::exact((0.0, *end), Y_TICKS),
                Axis::padded(force, Y_TICKS),
                "Feedback force per step (N/m)",
            )
        });
    }
    rows.push(Row { title: None, height: 190.0, panels: last });
    Ok(Figure { name: view.name.clone(), legend: vec![], rows })
}
