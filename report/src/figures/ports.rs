//! The two-port of the teleoperator over frequency.

use super::FigureError;
use super::axis::{Axis, Y_TICKS, extent};
use super::figure::{Figure, Row};
use super::legend::Sample;
use super::panel::{Panel, Trace};
use super::style::{BLACK, COMPUTED, GREY, LIMIT, Stroke, TISSUE};

/// Maximum displayed value of Llewellyn's parameter. Every higher value is absolutely stable.
const MAX_LLEWELLYN: f64 = 3.0;

/// Columns over frequency, all of the same length.
#[derive(Clone, Debug)]
pub struct PortsView {
    /// Name of the scenario.
    pub name: String,
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
pub fn ports(view: &PortsView) -> Result<Figure<'static>, FigureError> {
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
    let ideal = Stroke::dashed(GREY, 1.6, &[9.0, 3.0]);
    let free = Stroke::dashed(BLACK, 1.0, &[1.4, 2.4]);
    let line = |y: &[f64], stroke| Trace::new(x.clone(), y.to_vec(), stroke);
    let panel = |y: Axis, y_caption: &str, traces, levels, legend: &[(Stroke, &str)]| Panel {
        traces,
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
                vec![line(&view.transmitted, TISSUE), line(&view.ideal, ideal), line(&view.free, free)],
                vec![],
                &[(TISSUE, "in tissue"), (ideal, "ideal: the scaled tissue"), (free, "in free motion")],
            ),
        ),
        Row::of(
            85.0,
            panel(
                Axis::exact((-2.2, MAX_LLEWELLYN + 0.2), Y_TICKS),
                "Llewellyn η",
                vec![line(&view.llewellyn, COMPUTED)],
                vec![(1.0, LIMIT)],
                &[(COMPUTED, "Llewellyn's parameter"), (LIMIT, "minimum for absolute stability")],
            ),
        ),
        Row::of(
            85.0,
            panel(
                Axis::exact((-1.1, 1.1), Y_TICKS),
                "Re Z / |Z|",
                vec![line(&view.transmitted_cosine, TISSUE), line(&view.free_cosine, free)],
                vec![(0.0, LIMIT)],
                &[(TISSUE, "in tissue"), (free, "in free motion"), (LIMIT, "minimum for passivity")],
            ),
        ),
    ];
    Ok(Figure { name: view.name.clone(), legend: vec![], rows })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn impedances_and_the_threshold_are_drawn() {
        let column = |value: f64| vec![value, 2.0 * value, f64::INFINITY];
        let view = PortsView {
            name: String::new(),
            frequency_hz: vec![0.1, 1.0, 10.0],
            transmitted: column(1.0),
            ideal: column(2.0),
            free: column(0.5),
            llewellyn: column(0.4),
            transmitted_cosine: vec![0.1, -0.2, f64::NAN],
            free_cosine: vec![0.1, 0.2, 0.3],
        };
        let svg = ports(&view).expect("a figure").page(500.0).svg();
        assert!(svg.contains("Llewellyn"));
        assert!(matches!(ports(&PortsView { ideal: vec![], ..view }), Err(FigureError::Length { .. })));
    }
}
