//! What events do to a motion, by how far they are apart.

use super::axis::{Axis, extent};
use super::grid::{Grid, Row, Sample};
use super::panel::{Panel, Trace};
use super::style::{RUNS, THRESHOLD};
use super::{Figure, FigureError};

/// What has died out in one event is drawn down to here.
const MIN_GROWTH: f64 = 1e-4;

/// Columns over the teleoperation between two events, all equally long; what is not there is no number.
#[derive(Clone, Debug)]
pub struct SwitchingView {
    /// s, increasing.
    pub dwell_s: Vec<f64>,
    /// Growth per event by the certificate.
    pub certified: Vec<f64>,
    /// That of the worst sequence found.
    pub found: Vec<f64>,
    /// What no sequence of those tried exceeds.
    pub enumerated: Vec<f64>,
}

/// Growth per event over the teleoperation between two events; below 1 motions die out.
///
/// # Errors
/// [`FigureError::Empty`] without a dwell, [`FigureError::Length`] for columns of unequal lengths.
pub fn switching(view: &SwitchingView) -> Result<Figure, FigureError> {
    let columns =
        [("certified", view.certified.len()), ("found", view.found.len()), ("enumerated", view.enumerated.len())];
    super::check("switching", "switching", view.dwell_s.len(), &columns)?;
    let Some((low, high)) = extent(view.dwell_s.iter().copied()) else {
        return Err(FigureError::Empty { figure: "switching" });
    };
    let x_axis = Axis::log10((low / 1.1, high * 1.1));
    let x: Vec<f64> = view.dwell_s.iter().map(|dwell| x_axis.place(*dwell)).collect();
    let all = view.certified.iter().chain(&view.found).chain(&view.enumerated).copied();
    let (least, most) = extent(all.filter(|value| *value > 0.0)).unwrap_or((0.1, 1.0));
    let least = least.max(MIN_GROWTH);
    let [certified, found, enumerated] = [RUNS[0], RUNS[1], RUNS[2]];
    let line = |y, stroke| Trace { x: &x, y, scale: 1.0, stroke };
    let panel = Panel {
        x_caption: "Teleoperation between events (s)",
        traces: vec![line(&view.certified, certified), line(&view.enumerated, enumerated), line(&view.found, found)],
        levels: vec![(1.0, THRESHOLD)],
        ..Panel::over_time(x_axis, Axis::log10((least / 1.5, 1.5 * most.max(1.0))), "Growth per event")
    };
    let rows = vec![Row { title: None, height: 560.0, panels: vec![panel] }];
    let legend = vec![
        (Sample::Line(certified), "at most, certified for any events and tissue".to_owned()),
        (Sample::Line(found), "the worst sequence found".to_owned()),
        (Sample::Line(enumerated), "at most, of the sequences tried".to_owned()),
        (Sample::Line(THRESHOLD), "above 1 motions grow".to_owned()),
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
            enumerated: vec![0.31, 0.21, 0.11],
        };
        let figure = switching(&view).expect("a figure");
        assert!(figure.svg.contains("Growth per event"));
        assert!(matches!(switching(&SwitchingView { found: vec![], ..view }), Err(FigureError::Length { .. })));
    }
}
