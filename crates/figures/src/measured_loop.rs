use super::FigureError;
use super::loop_response::{MIN_MAGNITUDE, NYQUIST};
use trocar_document::figure::{Axis, BLACK, BLUE, Figure, LIMIT, PURPLE, Panel, Row, Sample, Stroke, Y_TICKS, extent};
use trocar_lti::Complex64;
use trocar_stability::{LoopResponse, MeasuredLoop};

const MEASURED: Stroke = Stroke::solid(BLUE, 1.8);
const MODEL: Stroke = Stroke::dashed(BLACK, 0.9, &[4.0, 2.5]);

pub fn measured_loop(
    name: &str,
    measured: &MeasuredLoop,
    model: &LoopResponse,
) -> Result<Figure<'static>, FigureError> {
    let Some(range_hz) = extent(measured.gain.iter().map(|(hertz, _)| *hertz)) else {
        return Err(FigureError::Empty { figure: "measured" });
    };
    let x_axis = Axis::log10(range_hz);
    let within = |gain: &[(f64, Complex64)]| -> Vec<(f64, Complex64)> {
        gain.iter().filter(|(hertz, _)| (range_hz.0..=range_hz.1).contains(hertz)).copied().collect()
    };
    let both = [(measured.gain.clone(), MEASURED), (within(&model.gain), MODEL)];
    let magnitudes = both.iter().flat_map(|(gain, _)| gain.iter().map(|(_, gain)| gain.norm()));
    let (min, max) = extent(magnitudes.filter(|value| *value > 0.0)).unwrap_or((0.1, 1.0));
    let of_magnitude = Axis::log10((min.max(MIN_MAGNITUDE) / 1.5, 1.5 * max.max(1.0)));
    let mark = Stroke::solid(PURPLE, 5.0);
    let limit = measured.limit.map(|(factor, hertz)| (hertz, 1.0 / factor));
    let curve = |values: Vec<f64>, gain: &[(f64, Complex64)]| -> Vec<(f64, f64)> {
        gain.iter().map(|(hertz, _)| x_axis.place(*hertz)).zip(values).collect()
    };
    let bode = both.iter().map(|(gain, stroke)| {
        let drawn = gain.iter().filter(|(_, gain)| gain.norm() >= MIN_MAGNITUDE);
        let curve = drawn.map(|(hertz, gain)| (x_axis.place(*hertz), of_magnitude.place(gain.norm())));
        (curve.collect(), *stroke)
    });
    let at_limit = limit.map(|(hertz, gain)| (vec![(x_axis.place(hertz), of_magnitude.place(gain))], mark));
    let entry = |sample, text: &str| (sample, text.to_owned());
    let magnitude = Panel {
        levels: vec![(1.0, LIMIT)],
        curves: bode.chain(at_limit).collect(),
        legend: [entry(Sample::Line(MEASURED), "measured"), entry(Sample::Line(MODEL), "model")]
            .into_iter()
            .chain([entry(Sample::Line(LIMIT), "gain of 1")])
            .chain(limit.map(|_| entry(Sample::Dot(mark), "gain margin")))
            .collect(),
        ..Panel::new(x_axis.clone(), "Frequency (Hz)", of_magnitude.clone(), "|L|")
    };
    let phases: Vec<Vec<f64>> = both.iter().map(|(gain, _)| LoopResponse::unwrapped_deg(gain)).collect();
    let range = extent(phases.iter().flatten().copied()).unwrap_or((-180.0, 0.0));
    let phase = both.iter().zip(&phases).map(|((gain, stroke), phases)| (curve(phases.clone(), gain), *stroke));
    let phase = Panel {
        curves: phase.collect(),
        ..Panel::new(x_axis.clone(), "Frequency (Hz)", Axis::padded(range, Y_TICKS), "Phase of L (°)")
    };
    let square = || Axis::exact((-NYQUIST, NYQUIST), Y_TICKS);
    let critical = Stroke::solid(PURPLE, 8.0);
    let plane = |gain: &[(f64, Complex64)]| gain.iter().map(|(_, gain)| (gain.re, gain.im)).collect();
    let nyquist = Panel {
        curves: both
            .iter()
            .map(|(gain, stroke)| (plane(gain), *stroke))
            .chain([(vec![(1.0, 0.0)], critical)])
            .collect(),
        legend: vec![entry(Sample::Dot(critical), "critical point")],
        ..Panel::new(square(), "Re L", square(), "Im L")
    };
    let rows = vec![
        Row::of(100.0, magnitude),
        Row::of(80.0, phase),
        Row { title: None, height: 190.0, panels: vec![nyquist] },
    ];
    Ok(Figure { name: name.to_owned(), legend: vec![], rows })
}
