//! The energies at the ports of a run, and the balance of the parts between them.

use super::axis::{Axis, X_TICKS, Y_TICKS, extent, union};
use super::figure::{Figure, Row};
use super::legend::{Entry, Sample};
use super::panel::{Panel, Trace};
use super::style::{BLACK, COMPUTED, GREY, HAND, LIMIT, Stroke, TISSUE};
use super::{FigureError, check};

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
type Line<'a> = (Vec<f64>, Stroke, &'a str);

/// The two ends of the link.
const AT_MASTER: Stroke = Stroke::dashed(GREY, 1.6, &[9.0, 3.0]);
const AT_SLAVE: Stroke = Stroke::dashed(BLACK, 1.0, &[1.4, 2.4]);

/// Draws the energy that has passed each port (above) and what each part has received less what it has delivered (below). A
/// balance below 0 is generated energy; the line at `-E_0` is what the passivity scheme promises for the total.
///
/// # Errors
/// [`FigureError::Empty`] without samples, [`FigureError::Length`] for columns of unequal lengths.
pub fn energy<'a>(view: &EnergyView<'a>) -> Result<Figure<'a>, FigureError> {
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
    let ports: Vec<Line<'_>> = vec![
        (view.needle_j.to_vec(), TISSUE, "into the tissue"),
        (view.master_j.to_vec(), AT_MASTER, "into the link"),
        (view.reference_j.to_vec(), AT_SLAVE, "out of the link"),
        (view.hand_j.to_vec(), HAND, "from the hand"),
    ];
    let balances: Vec<Line<'_>> = vec![
        (master, HAND, "master"),
        (link, AT_MASTER, "link"),
        (slave, AT_SLAVE, "slave"),
        (total, COMPUTED, "link and slave"),
    ];
    let time = Axis::exact(extent(view.time_s.iter().copied()).unwrap_or((0.0, 1.0)), X_TICKS);
    let level = view.promised_j.map(|promised_j| -1e3 * promised_j);
    let rows = [(ports, None, "Energy (mJ)"), (balances, level, "Balance (mJ)")].map(|(lines, level, y_caption)| {
        let ranges = lines.iter().map(|(values, ..)| extent(values.iter().map(|value| 1e3 * value)));
        let range = ranges.fold(level.map(|level| (level, level)), union).unwrap_or((0.0, 1.0));
        let names = lines.iter().map(|&(_, stroke, name)| (Sample::Line(stroke), name.to_owned()));
        let promise: Option<Entry> = level.map(|_| (Sample::Line(LIMIT), "minimum by the passivity scheme".to_owned()));
        Row::of(
            125.0,
            Panel {
                legend: names.chain(promise).collect(),
                traces: lines.into_iter().map(|(y, line, _)| Trace::new(view.time_s, y, line).times(1e3)).collect(),
                levels: level.into_iter().map(|level| (level, LIMIT)).collect(),
                ..Panel::over_time(time.clone(), Axis::padded(range, Y_TICKS), y_caption)
            },
        )
    });
    Ok(Figure { name: view.name.to_owned(), legend: vec![], rows: rows.into() })
}
