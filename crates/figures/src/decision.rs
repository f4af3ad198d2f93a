//! The decision function of the detector and its alarms, as in figure 13 of the paper.

use super::{EstimationView, FigureError, events};
use trocar_document::figure::{
    Axis, COMPUTED, Events, Figure, LIMIT, Panel, Row, Sample, Series, TISSUE, X_TICKS, Y_TICKS, extent,
};

/// Maximum ratio of the peak to the threshold on a linear axis. Above it the axis is logarithmic, because the threshold
/// would be at the bottom.
const MAX_LINEAR_PEAK: f64 = 30.0;
const LOG_FLOOR: f64 = 1e-2;

/// Draws the decision function with its threshold γ (above), and the force with alarms and true ruptures (below).
pub fn decision<'a>(view: &EstimationView<'a>) -> Result<Figure<'a>, FigureError> {
    view.check("decision")?;
    let (time, window) = view.time_axis(X_TICKS);
    let events = events::of_estimation(view);
    let mut upper = decision_panel(&[view], time.clone(), events.clone());
    upper.series.push(Series::new(view.time_s, view.decision, COMPUTED));
    let lower = Panel {
        events: events.clone(),
        series: vec![Series::new(view.time_s, view.measured_force_n, TISSUE)],
        ..Panel::over_time(time, view.force_axis(), "Measured force (N)")
    };
    Ok(Figure {
        name: view.name.to_owned(),
        legend: events::entries(&[&events], window),
        rows: vec![Row::of(115.0, upper), Row::of(115.0, lower)],
    })
}

pub(super) fn decision_panel<'a>(views: &[&EstimationView<'_>], time: Axis, events: Events) -> Panel<'a> {
    let unit = views.first().map(|view| view.decision_unit).filter(|unit| *unit != "1").unwrap_or_default();
    let caption = if unit.is_empty() { String::new() } else { format!(" ({unit})") };
    let mut thresholds: Vec<f64> = views.iter().map(|view| view.threshold).filter(|value| value.is_finite()).collect();
    thresholds.sort_by(f64::total_cmp);
    thresholds.dedup();
    let peak = extent(views.iter().flat_map(|view| view.decision).copied()).map_or(0.0, |range| range.1);
    let y = decision_axis(peak, thresholds.last().copied().unwrap_or(0.0));
    let text = thresholds.iter().map(|value| short(*value)).collect::<Vec<_>>().join(", ");
    Panel {
        events,
        levels: thresholds.iter().map(|value| (*value, LIMIT)).collect(),
        legend: if thresholds.is_empty() {
            vec![]
        } else {
            vec![(Sample::Line(LIMIT), format!("threshold γ = {text} {unit}").trim_end().to_owned())]
        },
        ..Panel::over_time(time, y, format!("Decision function g{caption}"))
    }
}

fn decision_axis(peak: f64, threshold: f64) -> Axis {
    if threshold > 0.0 && peak > MAX_LINEAR_PEAK * threshold {
        return Axis::log10((LOG_FLOOR * threshold, 2.0 * peak));
    }
    Axis::from_zero(peak.max(1.4 * threshold), Y_TICKS)
}

pub(super) fn short(value: f64) -> String {
    let decimals = if value == 0.0 { 0 } else { (2.0 - value.abs().log10().floor()).clamp(0.0, 9.0) as usize };
    let text = format!("{value:.decimals$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

#[cfg(test)]
mod tests {
    use super::short;

    #[test]
    fn thresholds_have_three_significant_digits() {
        assert_eq!(short(1.98e-2), "0.0198");
        assert_eq!(short(5.0), "5");
        assert_eq!(short(0.0), "0");
        assert_eq!(short(1200.0), "1200");
    }
}
