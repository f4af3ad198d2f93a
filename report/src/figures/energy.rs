//! The energies at the ports of a run, and the balance of the parts between them.

use super::axis::{Axis, X_TICKS, Y_TICKS, extent, union};
use super::grid::{Grid, Row, Sample};
use super::panel::{Panel, Trace};
use super::style::{ALONE, BLACK, GREEN, GREY, HUMAN, MAIN, PURPLE, Stroke, UNDERLAY};
use super::{Figure, FigureError, check};

/// The energies of a run over time. All columns have the same length.
#[derive(Clone, Copy, Debug)]
pub struct EnergyView<'a> {
    /// Name of the run.
    pub name: &'a str,
    /// Time, s, increasing.
    pub time_s: &'a [f64],
    /// Work of the hand on the master, J.
    pub hand_j: &'a [f64],
    /// Work of the hand on the feedback force, J.
    pub master_j: &'a [f64],
    /// Work of the reference on the tissue force, J.
    pub reference_j: &'a [f64],
    /// Work of the needle on the tissue, J.
    pub needle_j: &'a [f64],
    /// Energy at the master per energy at the slave.
    pub energy_scale: f64,
    /// Energy that the passivity scheme may generate, J.
    pub promised_j: Option<f64>,
}

/// An energy, its line, its name in the legend.
type Line<'a> = (&'a [f64], Stroke, &'static str);

const MASTER: Stroke = Stroke::solid(GREEN, 2.75);
const SLAVE: Stroke = Stroke { color: PURPLE, width: 2.75, dashes: &[4.0, 6.0] };
const TOTAL: Stroke = Stroke::solid(BLACK, 3.25);
const PROMISE: Stroke = Stroke { color: GREY, width: 2.5, dashes: &[12.0, 8.0] };

/// Draws the energy that has passed each port (above) and what each part has received less what it has delivered (below). A
/// balance below 0 is generated energy; the line at `-E_0` is what the passivity scheme promises for the total.
///
/// # Errors
/// [`FigureError::Empty`] without samples, [`FigureError::Length`] for columns of unequal lengths.
pub fn energy(view: &EnergyView<'_>) -> Result<Figure, FigureError> {
    let lengths = [
        ("hand_energy_j", view.hand_j.len()),
        ("master_energy_j", view.master_j.len()),
        ("reference_energy_j", view.reference_j.len()),
        ("needle_energy_j", view.needle_j.len()),
    ];
    check("energy", view.name, view.time_s.len(), &lengths)?;
    let balance = |received: &[f64], (delivered, scale): (&[f64], f64)| -> Vec<f64> {
        received.iter().zip(delivered).map(|(received, delivered)| received - scale * delivered).collect()
    };
    let master = balance(view.hand_j, (view.master_j, 1.0));
    let link = balance(view.master_j, (view.reference_j, view.energy_scale));
    let slave = balance(view.reference_j, (view.needle_j, 1.0));
    let total = balance(view.master_j, (view.needle_j, view.energy_scale));
    let ports: [Line<'_>; 4] = [
        (view.reference_j, UNDERLAY, "out of the link at the slave"),
        (view.needle_j, MAIN, "into the tissue"),
        (view.hand_j, HUMAN, "from the hand"),
        (view.master_j, MASTER, "into the link at the master"),
    ];
    let balances: [Line<'_>; 4] = [
        (&master[..], ALONE, "master"),
        (&link[..], MASTER, "link"),
        (&slave[..], SLAVE, "slave"),
        (&total[..], TOTAL, "link and slave: E_m - E_s"),
    ];
    let time = Axis::exact(extent(view.time_s.iter().copied()).unwrap_or((0.0, 1.0)), X_TICKS);
    let level = view.promised_j.map(|promised_j| -1e3 * promised_j);
    let rows = [(&ports, None, "Energy (mJ)"), (&balances, level, "Balance (mJ)")].map(|(lines, level, y_caption)| {
        let ranges = lines.iter().map(|(values, ..)| extent(values.iter().map(|value| 1e3 * value)));
        let range = ranges.fold(level.map(|level| (level, level)), union).unwrap_or((0.0, 1.0));
        let traces = lines.iter().map(|&(y, stroke, _)| Trace { x: view.time_s, y, scale: 1e3, stroke });
        let panel = Panel {
            traces: traces.collect(),
            levels: level.into_iter().map(|level| (level, PROMISE)).collect(),
            ..Panel::over_time(time.clone(), Axis::padded(range, Y_TICKS), y_caption)
        };
        Row { title: None, height: 400.0, panels: vec![panel] }
    });
    let entries = |lines: &[Line<'_>; 4]| -> Vec<_> {
        lines.iter().map(|&(_, stroke, name)| (Sample::Line(stroke), name.to_owned())).collect()
    };
    let mut legend = entries(&ports);
    legend.extend(entries(&balances).into_iter().map(|(sample, name)| (sample, format!("below: {name}"))));
    if level.is_some() {
        legend.push((Sample::Line(PROMISE), "-E_0".to_owned()));
    }
    Grid { legends: vec![legend], common: vec![], rows: rows.into() }.draw()
}
