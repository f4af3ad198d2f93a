//! Growth of the motion per event, against the time between events.

use super::axis::{Axis, extent};
use super::grid::{Grid, Row, Sample};
use super::panel::{Panel, Trace};
use super::style::{RUNS, THRESHOLD};
use super::{Figure, FigureError};

/// Lower limit of the growth axis.
const MIN_GROWTH: f64 = 1e-4;

/// Columns over the teleoperation between two events, all of the same length. A missing value is NaN.
#[derive(Clone, Debug)]
pub struct SwitchingView {
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
pub fn switching(view: &SwitchingView) -> Result<Figure, FigureError> {
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
    let [certified, found] = [RUNS[0], RUNS[1]];
    let line = |y, stroke| Trace { x: &x, y, scale: 1.0, stroke };
    let panel = Panel {
        x_caption: "Teleoperation between events (s)",
        traces: vec![line(&view.certified, certified), line(&view.found, found)],
        levels: vec![(1.0, THRESHOLD)],
        ..Panel::over_time(x_axis, Axis::log10((min / 1.5, 1.5 * max.max(1.0))), "Growth per event")
    };
    let rows = vec![Row { title: None, height: 560.0, panels: vec![panel] }];
    let legend = vec![
        (Sample::Line(certified), "certified bound for any events and tissue".to_owned()),
        (Sample::Line(found), "worst sequence found".to_owned()),
        (Sample::Line(THRESHOLD), "above 1 the motion grows".to_owned()),
    ];
    Grid { legends: vec![legend], common: vec![], rows }.draw()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dwells_without_a_certificate_leave_a_gap() {
        let view = SwitchingView {
            dwell_s: vec![0.01, 0.1, 1.0],
            certified: vec![f64::NAN, 0.9, 0.8],
            found: vec![0.3, 0.2, 0.1],
        };
        let figure = switching(&view).expect("a figure");
        assert!(figure.svg.contains("Growth per event"));
        assert!(matches!(switching(&SwitchingView { found: vec![], ..view }), Err(FigureError::Length { .. })));
    }
}
