//! The two-port of the teleoperator over frequency.

use super::axis::{Axis, Y_TICKS, extent};
use super::grid::{Grid, Row, Sample};
use super::panel::{Panel, Trace};
use super::style::{RUNS, Stroke, THRESHOLD};
use super::{Figure, FigureError};

/// Maximum displayed value of Llewellyn's parameter. Every higher value is absolutely stable.
const MAX_LLEWELLYN: f64 = 3.0;

/// Columns over frequency, all of the same length.
#[derive(Clone, Debug)]
pub struct PortsView {
    /// Hz, increasing.
    pub frequency_hz: Vec<f64>,
    /// `|Z_t|` in N·s/m.
    pub transmitted: Vec<f64>,
    /// The scales times `|Z_e|`.
    pub ideal: Vec<f64>,
    /// `|h11|`.
    pub free: Vec<f64>,
    /// Llewellyn's parameter.
    pub llewellyn: Vec<f64>,
    /// Cosine of the angle of `Z_t`.
    pub transmitted_cosine: Vec<f64>,
    /// Cosine of the angle of `h11`.
    pub free_cosine: Vec<f64>,
}

/// Draws the impedances (above), Llewellyn's parameter with its threshold (middle), and the real part of the hand's port relative
/// to its magnitude (below), which is negative if the port is active.
///
/// # Errors
/// [`FigureError::Empty`] without frequencies, [`FigureError::Length`] for columns of unequal lengths.
pub fn ports(view: &PortsView) -> Result<Figure, FigureError> {
    let columns = [
        ("transmitted", view.transmitted.len()),
        ("ideal", view.ideal.len()),
        ("free", view.free.len()),
        ("llewellyn", view.llewellyn.len()),
        ("transmitted_cosine", view.transmitted_cosine.len()),
        ("free_cosine", view.free_cosine.len()),
    ];
    super::check("ports", "ports", view.frequency_hz.len(), &columns)?;
    let Some((low, high)) = extent(view.frequency_hz.iter().copied()) else {
        return Err(FigureError::Empty { figure: "ports" });
    };
    let x_axis = Axis::log10((low, high));
    let x: Vec<f64> = view.frequency_hz.iter().map(|frequency| x_axis.place(*frequency)).collect();
    let magnitudes = view.transmitted.iter().chain(&view.ideal).chain(&view.free).copied();
    let (min, max) = extent(magnitudes.filter(|value| *value > 0.0)).unwrap_or((0.1, 10.0));
    let impedance = Axis::log10((min.max(1e-6 * max) / 1.5, 1.5 * max));
    let [transmitted, ideal, free] = [RUNS[1], RUNS[0], RUNS[2]];
    let line = |y, stroke| Trace { x: &x, y, scale: 1.0, stroke };
    let panel = |y: Axis, y_caption, traces, levels| Panel {
        x_caption: "Frequency (Hz)",
        traces,
        levels,
        ..Panel::over_time(x_axis.clone(), y, y_caption)
    };
    let shown: Vec<f64> = view.llewellyn.iter().map(|value| value.clamp(-2.0, MAX_LLEWELLYN)).collect();
    let zero = Stroke { width: 2.0, ..THRESHOLD };
    let rows = vec![
        Row {
            title: None,
            height: 430.0,
            panels: vec![panel(
                impedance,
                "Impedance (N·s/m)",
                vec![line(&view.ideal, ideal), line(&view.free, free), line(&view.transmitted, transmitted)],
                vec![],
            )],
        },
        Row {
            title: None,
            height: 260.0,
            panels: vec![panel(
                Axis::exact((-2.2, MAX_LLEWELLYN + 0.2), Y_TICKS),
                "Llewellyn η",
                vec![line(&shown, RUNS[3])],
                vec![(1.0, THRESHOLD)],
            )],
        },
        Row {
            title: None,
            height: 260.0,
            panels: vec![panel(
                Axis::exact((-1.1, 1.1), Y_TICKS),
                "Re Z / |Z|",
                vec![line(&view.free_cosine, free), line(&view.transmitted_cosine, transmitted)],
                vec![(0.0, zero)],
            )],
        },
    ];
    let legend = vec![
        (Sample::Line(transmitted), "in tissue".to_owned()),
        (Sample::Line(ideal), "ideal: the scaled tissue".to_owned()),
        (Sample::Line(free), "in free motion".to_owned()),
        (Sample::Line(RUNS[3]), "Llewellyn's parameter".to_owned()),
        (Sample::Line(THRESHOLD), "minimum: η = 1 for absolute stability, Re Z = 0 for passivity".to_owned()),
    ];
    Grid { legends: vec![legend], common: vec![], rows }.draw()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn impedances_and_the_threshold_are_drawn() {
        let column = |value: f64| vec![value, 2.0 * value, f64::INFINITY];
        let view = PortsView {
            frequency_hz: vec![0.1, 1.0, 10.0],
            transmitted: column(1.0),
            ideal: column(2.0),
            free: column(0.5),
            llewellyn: column(0.4),
            transmitted_cosine: vec![0.1, -0.2, f64::NAN],
            free_cosine: vec![0.1, 0.2, 0.3],
        };
        let figure = ports(&view).expect("a figure");
        assert!(figure.svg.contains("Llewellyn"));
        assert!(matches!(ports(&PortsView { ideal: vec![], ..view }), Err(FigureError::Length { .. })));
    }
}
