//! Growth of the motion per event, against the time between events.

use super::FigureError;
use super::axis::{Axis, extent};
use super::figure::{Figure, Row};
use super::legend::Sample;
use super::panel::{Panel, Trace};
use super::style::{BLACK, COMPUTED, LIMIT, Stroke};

/// Lower limit of the growth axis.
const MIN_GROWTH: f64 = 1e-4;

/// Columns over the teleoperation between two events, all of the same length. A missing value is NaN.
#[derive(Clone, Debug)]
pub struct SwitchingView {
    /// Name of the scenario.
    pub name: String,
    /// Teleoperation between two events, s, increasing.
    pub dwell_s: Vec<f64>,
    /// Certified upper bound of the growth per event.
    pub certified: Vec<f64>,
    /// Growth per event of the worst sequence found.
    pub found: Vec<f64>,
}

/// Draws the growth per event against the teleoperation between two events. Below 1 the motion decays.
///
/// # Errors
/// [`FigureError::Empty`] without a dwell, [`FigureError::Length`] for columns of unequal lengths.
pub fn switching(view: &SwitchingView) -> Result<Figure<'static>, FigureError> {
    let columns = [("certified", view.certified.len()), ("found", view.found.len())];
    super::check("switching", "switching", view.dwell_s.len(), &columns)?;
    let Some((low, high)) = extent(view.dwell_s.iter().copied()) else {
        return Err(FigureError::Empty { figure: "switching" });
    };
    let x_axis = Axis::log10((low / 1.1, high * 1.1));
    let x: Vec<f64> = view.dwell_s.iter().map(|dwell| x_axis.place(*dwell)).collect();
    let all = view.certified.iter().chain(&view.found).copied();
    let (min, max) = extent(all.filter(|value| *value > 0.0)).unwrap_or((0.1, 1.0));
    let min = min.max(MIN_GROWTH);
    let certified = Stroke::dashed(BLACK, 1.1, &[5.0, 2.5]);
    let panel = Panel {
        traces: vec![
            Trace::new(x.clone(), view.certified.clone(), certified),
            Trace::new(x, view.found.clone(), COMPUTED),
        ],
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
        name: view.name.clone(),
        legend: legend.map(|(line, text)| (Sample::Line(line), text.to_owned())).into(),
        rows: vec![Row::of(180.0, panel)],
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dwells_without_a_certificate_leave_a_gap() {
        let view = SwitchingView {
            name: String::new(),
            dwell_s: vec![0.01, 0.1, 1.0],
            certified: vec![f64::NAN, 0.9, 0.8],
            found: vec![0.3, 0.2, 0.1],
        };
        let svg = switching(&view).expect("a figure").page(500.0).svg();
        assert!(svg.contains("Growth per event"));
        assert!(matches!(switching(&SwitchingView { found: vec![], ..view }), Err(FigureError::Length { .. })));
    }
}
