use super::FigureError;
use trocar_document::figure::{Axis, BLACK, COMPUTED, Figure, LIMIT, Panel, Row, Sample, Series, Stroke, extent};
use trocar_stability::DwellPoint;

const MIN_GROWTH: f64 = 1e-4;

/// Draws the growth per event over the teleoperation between two events. Below 1 the motion decays.
pub fn switching(name: &str, points: &[DwellPoint], tick_s: f64) -> Result<Figure<'static>, FigureError> {
    let dwell_s: Vec<f64> = points.iter().map(|point| point.dwell_ticks as f64 * tick_s).collect();
    let bounds: Vec<f64> = points.iter().map(|point| point.certified.unwrap_or(f64::NAN)).collect();
    let found: Vec<f64> = points.iter().map(|point| point.found).collect();
    let Some((low, high)) = extent(dwell_s.iter().copied()) else {
        return Err(FigureError::Empty { figure: "switching" });
    };
    let x_axis = Axis::log10((low / 1.1, high * 1.1));
    let x: Vec<f64> = dwell_s.iter().map(|dwell| x_axis.place(*dwell)).collect();
    let all = bounds.iter().chain(&found).copied();
    let (min, max) = extent(all.filter(|value| *value > 0.0)).unwrap_or((0.1, 1.0));
    let min = min.max(MIN_GROWTH);
    let certified = Stroke::dashed(BLACK, 1.1, &[5.0, 2.5]);
    let panel = Panel {
        series: vec![Series::new(x.clone(), bounds, certified), Series::new(x, found, COMPUTED)],
        levels: vec![(1.0, LIMIT)],
        ..Panel::new(
            x_axis,
            "Teleoperation between events (s)",
            Axis::log10((min / 1.5, 1.5 * max.max(1.0))),
            "Growth per event",
        )
    };
    let legend = [
        (certified, "certified bound for any events and tissue"),
        (COMPUTED, "worst sequence found"),
        (LIMIT, "above 1 the motion grows"),
    ];
    Ok(Figure {
        name: name.to_owned(),
        legend: legend.map(|(line, text)| (Sample::Line(line), text.to_owned())).into(),
        rows: vec![Row::of(180.0, panel)],
    })
}
