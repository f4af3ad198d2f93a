use super::FigureError;
use trocar_document::figure::{
    Axis, BLACK, COMPUTED, Figure, GREY, LIMIT, Panel, Row, Sample, Series, Stroke, TISSUE, Y_TICKS, extent,
};
use trocar_stability::PortPoint;

/// Maximum displayed value of Llewellyn's parameter, far within absolute stability.
const MAX_LLEWELLYN: f64 = 3.0;

/// Draws the impedances (above), Llewellyn's parameter with its threshold (middle), and the real part of the hand's
/// port relative to its magnitude (below), negative for an active port.
pub fn ports(name: &str, points: &[PortPoint]) -> Result<Figure<'static>, FigureError> {
    let column = |of: fn(&PortPoint) -> f64| points.iter().map(of).collect::<Vec<f64>>();
    let frequency_hz = column(|point| point.frequency_hz);
    let [transmitted, ideal, free] = [
        column(|point| point.transmitted.norm()),
        column(|point| point.ideal.norm()),
        column(|point| point.hybrid.h[0][0].norm()),
    ];
    let transmitted_cosine = column(|point| point.transmitted.re / point.transmitted.norm());
    let free_cosine = column(|point| point.hybrid.h[0][0].re / point.hybrid.h[0][0].norm());
    let Some((low, high)) = extent(frequency_hz.iter().copied()) else {
        return Err(FigureError::Empty { figure: "ports" });
    };
    let x_axis = Axis::log10((low, high));
    let x: Vec<f64> = frequency_hz.iter().map(|frequency| x_axis.place(*frequency)).collect();
    let magnitudes = transmitted.iter().chain(&ideal).chain(&free).copied();
    let (min, max) = extent(magnitudes.filter(|value| *value > 0.0)).unwrap_or((0.1, 10.0));
    let impedance = Axis::log10((min.max(1e-6 * max) / 1.5, 1.5 * max));
    let of_ideal = Stroke::dashed(GREY, 1.6, &[9.0, 3.0]);
    let of_free = Stroke::dashed(BLACK, 1.0, &[1.4, 2.4]);
    let line = |y: Vec<f64>, stroke| Series::new(x.clone(), y, stroke);
    let panel = |y: Axis, y_caption: &str, series, levels, legend: &[(Stroke, &str)]| Panel {
        series,
        levels,
        legend: legend.iter().map(|(stroke, name)| (Sample::Line(*stroke), (*name).to_owned())).collect(),
        ..Panel::new(x_axis.clone(), "Frequency (Hz)", y, y_caption)
    };
    let rows = vec![
        Row::of(
            130.0,
            panel(
                impedance,
                "Impedance (N·s/m)",
                vec![line(transmitted, TISSUE), line(ideal, of_ideal), line(free, of_free)],
                vec![],
                &[(TISSUE, "in tissue"), (of_ideal, "ideal: the scaled tissue"), (of_free, "in free motion")],
            ),
        ),
        Row::of(
            85.0,
            panel(
                Axis::exact((-2.2, MAX_LLEWELLYN + 0.2), Y_TICKS),
                "Llewellyn η",
                vec![line(column(|point| point.hybrid.llewellyn()), COMPUTED)],
                vec![(1.0, LIMIT)],
                &[(COMPUTED, "Llewellyn's parameter"), (LIMIT, "minimum for absolute stability")],
            ),
        ),
        Row::of(
            85.0,
            panel(
                Axis::exact((-1.1, 1.1), Y_TICKS),
                "Re Z / |Z|",
                vec![line(transmitted_cosine, TISSUE), line(free_cosine, of_free)],
                vec![(0.0, LIMIT)],
                &[(TISSUE, "in tissue"), (of_free, "in free motion"), (LIMIT, "minimum for passivity")],
            ),
        ),
    ];
    Ok(Figure { name: name.to_owned(), legend: vec![], rows })
}
