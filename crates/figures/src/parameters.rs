//! The estimated tissue parameters over time, as in figures 5 and 7 of the paper, with their standard errors.

use super::{EstimationView, FigureError, events};
use trocar_document::figure::{
    Axis, COMPUTED, Color, Events, Figure, GREY, Panel, Point, Row, Sample, Series, X_TICKS, Y_TICKS, quantile_extent,
};

/// Quantile for the axes, because the first estimates after contact can be very large.
const SHOWN: f64 = 0.995;

/// Half width of the band in standard errors.
pub const STANDARD_ERRORS: f64 = 2.0;
const BAND_COLOR: Color = GREY.pale(0.4);

const EDGE_POINTS: usize = 800;

/// Draws the estimated stiffness, damping and extra parameter (if any), one below the other. A band shows two standard
/// errors on either side, if known. The axes span the quantiles from 0.5 % to 99.5 %; values beyond are cut off.
pub fn parameters<'a>(view: &EstimationView<'a>) -> Result<Figure<'a>, FigureError> {
    view.check("parameters")?;
    let (time, window) = view.time_axis(X_TICKS);
    let events = events::of_estimation(view);
    let row = |y, y_caption, std| parameter(view.time_s, &time, &events, y, y_caption, std);
    let [of_stiffness, of_damping] =
        view.standard_errors.as_ref().map_or([None; 2], |[one, other]| [Some(&**one), Some(&**other)]);
    let mut rows = vec![
        row(view.stiffness_n_per_m, "Stiffness (N/m)", of_stiffness),
        row(view.damping_n_s_per_m, "Damping (N·s/m)", of_damping),
    ];
    rows.extend(view.extra_parameter.map(|(name, column)| row(column, extra_caption(name), None)));
    let band = view
        .standard_errors
        .as_ref()
        .map(|_| (Sample::Shade(BAND_COLOR), format!("estimate ± {STANDARD_ERRORS} standard errors")));
    let legend = band.into_iter().chain(events::entries(&[&events], window)).collect();
    Ok(Figure { name: view.name.to_owned(), legend, rows })
}

pub(super) fn extra_caption(column: &str) -> &'static str {
    if column == "power" { "Power" } else { "Friction (N)" }
}

pub(super) fn estimate_axis<'a>(values: impl IntoIterator<Item = &'a f64>) -> Axis {
    Axis::padded(quantile_extent(values.into_iter().copied(), SHOWN).unwrap_or((0.0, 1.0)), Y_TICKS)
}

fn parameter<'a>(
    time_s: &'a [f64],
    time: &Axis,
    events: &Events,
    y: &'a [f64],
    y_caption: &str,
    std: Option<&[f64]>,
) -> Row<'a> {
    let axis = estimate_axis(y);
    let outlines = std.map_or(vec![], |std| band(time_s, y, std, (axis.low, axis.high)));
    let panel = Panel {
        events: events.clone(),
        fills: outlines.into_iter().map(|outline| (outline, BAND_COLOR)).collect(),
        series: vec![Series::new(time_s, y, COMPUTED)],
        ..Panel::over_time(time.clone(), axis, y_caption)
    };
    Row::of(115.0, panel)
}

/// Outlines of the band around a parameter, within an axis, from the extremes of each time interval.
fn band(time_s: &[f64], y: &[f64], std: &[f64], (low, high): (f64, f64)) -> Vec<Vec<Point>> {
    let per_point = y.len().div_ceil(EDGE_POINTS).max(1);
    let within = |value: f64| value.max(low).min(high);
    let mut lower = vec![];
    let mut upper = vec![];
    for ((time_s, y), std) in time_s.chunks(per_point).zip(y.chunks(per_point)).zip(std.chunks(per_point)) {
        let edges = |sign: f64| y.iter().zip(std).map(move |(y, std)| y + sign * STANDARD_ERRORS * std);
        let (bottom, top) = (edges(-1.0).fold(f64::INFINITY, f64::min), edges(1.0).fold(f64::NEG_INFINITY, f64::max));
        let middle_s = time_s[time_s.len() / 2];
        if middle_s.is_finite() && bottom <= top {
            lower.push((middle_s, within(bottom)));
            upper.push((middle_s, within(top)));
        }
    }
    if lower.len() < 2 { vec![] } else { vec![lower.into_iter().chain(upper.into_iter().rev()).collect()] }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_description_has_the_data_of_the_figure() {
        let time_s: Vec<f64> = (0..2000).map(|k| 1e-3 * f64::from(k)).collect();
        let stiffness: Vec<f64> = time_s.iter().map(|time_s| 200.0 + 50.0 * (3.0 * time_s).sin()).collect();
        let (zero, one) = (vec![0.0; 2000], vec![1.0; 2000]);
        let view = EstimationView {
            name: "a run",
            time_s: &time_s,
            measured_force_n: &zero,
            residual_n: &zero,
            stiffness_n_per_m: &stiffness,
            damping_n_s_per_m: &one,
            standard_errors: Some([(&one[..]).into(), (&one[..]).into()]),
            extra_parameter: None,
            decision: &zero,
            threshold: 1.0,
            decision_unit: "1",
            rupture_times_s: vec![0.5].into(),
            alarm_times_s: vec![0.52].into(),
        };
        let description = parameters(&view).expect("a figure").description();
        assert_eq!(description["name"], "a run");
        let panel = &description["rows"][0]["panels"][0];
        assert_eq!(
            (panel["y"]["caption"].as_str(), panel["x"]["log"].as_bool()),
            (Some("Stiffness (N/m)"), Some(false))
        );
        assert_eq!((panel["ruptures"][0].as_f64(), panel["alarms"][0].as_f64()), (Some(0.5), Some(0.52)));
        assert!(panel["fills"][0]["color"].as_str().is_some_and(|color| color.starts_with('#') && color.len() == 7));
        // With fewer samples than intervals, all samples remain.
        let [x, y] = [0, 1].map(|k| panel["lines"][0]["points"][k].as_array().expect("a column"));
        assert_eq!((x.len(), y.len()), (2000, 2000));
        assert!(y.iter().zip(&stiffness).all(|(drawn, value)| drawn.as_f64() == Some(*value)));
    }
}
