use super::FigureError;
use trocar_document::figure::{
    Axis, COMPUTED, Figure, LIMIT, PURPLE, Panel, Row, Sample, Series, Stroke, Y_TICKS, extent,
};
use trocar_stability::LoopResponse;

/// Minimum drawn magnitude, and the range of the Nyquist diagram.
pub(super) const MIN_MAGNITUDE: f64 = 1e-4;
pub(super) const NYQUIST: f64 = 1.6;

pub fn loop_response(name: &str, response: &LoopResponse) -> Result<Figure<'static>, FigureError> {
    let (frequency_hz, magnitude): (Vec<f64>, Vec<f64>) =
        response.gain.iter().map(|(hertz, gain)| (*hertz, gain.norm())).unzip();
    let phase_deg = response.phases_deg();
    let margins = &response.margins;
    let gain_margin = margins.gain.zip(margins.gain_frequency_hz);
    let Some((low, high)) = extent(frequency_hz.iter().copied()) else {
        return Err(FigureError::Empty { figure: "loop" });
    };
    let x_axis = Axis::log10((low, high));
    let x: Vec<f64> = frequency_hz.iter().map(|frequency| x_axis.place(*frequency)).collect();
    let (min, max) = extent(magnitude.iter().copied().filter(|value| *value > 0.0)).unwrap_or((0.1, 1.0));
    let of_magnitude = Axis::log10((min.max(MIN_MAGNITUDE) / 1.5, 1.5 * max.max(1.0)));
    let mark = Stroke::solid(PURPLE, 5.0);
    let of_gain =
        gain_margin.map(|(margin, hertz)| (vec![(x_axis.place(hertz), of_magnitude.place(1.0 / margin))], mark));
    let at_phase = margins.phase_frequency_hz.and_then(|hertz| {
        let next = frequency_hz.iter().position(|frequency| *frequency >= hertz)?;
        let (from, to) = (next.saturating_sub(1), next);
        let share = if to > from { (x_axis.place(hertz) - x[from]) / (x[to] - x[from]) } else { 0.0 };
        let phase = phase_deg[from] + share * (phase_deg[to] - phase_deg[from]);
        Some((x_axis.place(hertz), phase))
    });
    let of_phase = at_phase.map(|(place, _)| (vec![(place, of_magnitude.place(1.0))], mark));
    let marks = of_gain.into_iter().chain(of_phase).collect();
    let phase_mark = at_phase.map(|point| (vec![point], mark));
    let on_circle = at_phase.map(|(_, phase)| {
        let (im, re) = phase.to_radians().sin_cos();
        (vec![(re, im)], mark)
    });
    let trace = |x: &[f64], y: &[f64]| vec![Series::new(x.to_vec(), y.to_vec(), COMPUTED)];
    let entry = |sample, text: &str| (sample, text.to_owned());
    let shown = match (gain_margin, at_phase) {
        (Some(_), Some(_)) => Some("gain and phase margin"),
        (Some(_), None) => Some("gain margin"),
        (None, Some(_)) => Some("phase margin"),
        (None, None) => None,
    };
    let shown = shown.map(|name| entry(Sample::Dot(mark), name));
    let of_phase_margin = at_phase.map(|_| entry(Sample::Dot(mark), "phase margin"));
    let bode = Panel {
        series: trace(&x, &magnitude),
        levels: vec![(1.0, LIMIT)],
        curves: marks,
        legend: [entry(Sample::Line(COMPUTED), "loop gain L"), entry(Sample::Line(LIMIT), "gain of 1")]
            .into_iter()
            .chain(shown)
            .collect(),
        ..Panel::new(x_axis.clone(), "Frequency (Hz)", of_magnitude, "|L|")
    };
    let phase = extent(phase_deg.iter().copied()).unwrap_or((-180.0, 0.0));
    let phase = Panel {
        series: trace(&x, &phase_deg),
        curves: phase_mark.into_iter().collect(),
        ..Panel::new(x_axis, "Frequency (Hz)", Axis::padded(phase, Y_TICKS), "Phase of L (°)")
    };
    let square = || Axis::exact((-NYQUIST, NYQUIST), Y_TICKS);
    // The gain is not monotonic in its real part.
    let nyquist = response.gain.iter().map(|(_, gain)| (gain.re, gain.im)).collect();
    let critical = Stroke::solid(PURPLE, 8.0);
    let nyquist = Panel {
        curves: [(nyquist, COMPUTED), (vec![(1.0, 0.0)], critical)].into_iter().chain(on_circle).collect(),
        legend: std::iter::once(entry(Sample::Dot(critical), "critical point")).chain(of_phase_margin).collect(),
        ..Panel::new(square(), "Re L", square(), "Im L")
    };
    let mut rows = vec![Row::of(100.0, bode), Row::of(80.0, phase)];
    let mut last = vec![nyquist];
    if let Some(step) = &response.step
        && let Some(end) = step.time_s.last().filter(|end| **end > 0.0)
    {
        let of_step: Vec<f64> = step.outputs.row(2).iter().copied().collect();
        let force = extent(of_step.iter().copied()).unwrap_or((0.0, 1.0));
        last.push(Panel {
            series: trace(&step.time_s, &of_step),
            legend: vec![entry(Sample::Line(COMPUTED), "step of the desired position")],
            ..Panel::over_time(
                Axis::exact((0.0, *end), Y_TICKS),
                Axis::padded(force, Y_TICKS),
                "Feedback force per step (N/m)",
            )
        });
    }
    rows.push(Row { title: None, height: 190.0, panels: last });
    Ok(Figure { name: name.to_owned(), legend: vec![], rows })
}
