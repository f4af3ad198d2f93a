use super::FigureError;
use trocar_document::figure::{
    Axis, BLACK, COMPUTED, Entry, Figure, GREY, HAND, LIMIT, Panel, Row, Sample, Series, Stroke, TISSUE, X_TICKS,
    Y_TICKS, extent, union,
};

type Line<'a> = (Vec<f64>, Stroke, &'a str);

const AT_MASTER: Stroke = Stroke::dashed(GREY, 1.6, &[9.0, 3.0]);
const AT_SLAVE: Stroke = Stroke::dashed(BLACK, 1.0, &[1.4, 2.4]);

/// All columns have the same length.
#[derive(Clone, Copy, Debug)]
pub struct EnergyView<'a> {
    pub name: &'a str,
    /// Time, s, increasing.
    pub time_s: &'a [f64],
    /// From the hand to the master.
    pub hand_energy_j: &'a [f64],
    /// From the master to the link.
    pub master_energy_j: &'a [f64],
    /// From the link to the slave.
    pub reference_energy_j: &'a [f64],
    /// From the slave to the tissue.
    pub needle_energy_j: &'a [f64],
    /// Energy at the slave over energy at the master, from the scale factors.
    pub energy_scale: f64,
    /// The energy that the passivity scheme allows the link to generate.
    pub promised_energy_j: Option<f64>,
}

/// Draws the energy through each port (above), and the received minus the delivered energy of each part (below). Below
/// 0 a part generates energy; the line at `-E_0` is the passivity scheme's limit for the total.
pub fn energy<'a>(view: &EnergyView<'a>) -> Result<Figure<'a>, FigureError> {
    let EnergyView {
        time_s, hand_energy_j, master_energy_j, reference_energy_j, needle_energy_j, energy_scale, ..
    } = *view;
    let Some(range_s) = extent(time_s.iter().copied()) else { return Err(FigureError::Empty { figure: "energy" }) };
    let balance = |received: &[f64], (delivered, scale): (&[f64], f64)| -> Vec<f64> {
        received.iter().zip(delivered).map(|(received, delivered)| received - scale * delivered).collect()
    };
    let master = balance(hand_energy_j, (master_energy_j, 1.0));
    let link = balance(master_energy_j, (reference_energy_j, energy_scale));
    let slave = balance(reference_energy_j, (needle_energy_j, 1.0));
    let total = balance(master_energy_j, (needle_energy_j, energy_scale));
    let ports: Vec<Line<'_>> = vec![
        (needle_energy_j.to_vec(), TISSUE, "into the tissue"),
        (master_energy_j.to_vec(), AT_MASTER, "into the link"),
        (reference_energy_j.to_vec(), AT_SLAVE, "out of the link"),
        (hand_energy_j.to_vec(), HAND, "from the hand"),
    ];
    let balances: Vec<Line<'_>> = vec![
        (master, HAND, "master"),
        (link, AT_MASTER, "link"),
        (slave, AT_SLAVE, "slave"),
        (total, COMPUTED, "link and slave"),
    ];
    let time = Axis::exact(range_s, X_TICKS);
    let level = view.promised_energy_j.map(|promised_j| -1e3 * promised_j);
    let rows = [(ports, None, "Energy (mJ)"), (balances, level, "Balance (mJ)")].map(|(lines, level, y_caption)| {
        let ranges = lines.iter().map(|(values, ..)| extent(values.iter().map(|value| 1e3 * value)));
        let range = ranges.fold(level.map(|level| (level, level)), union).unwrap_or((0.0, 1.0));
        let names = lines.iter().map(|&(_, stroke, name)| (Sample::Line(stroke), name.to_owned()));
        let promise: Option<Entry> = level.map(|_| (Sample::Line(LIMIT), "minimum by the passivity scheme".to_owned()));
        Row::of(
            125.0,
            Panel {
                legend: names.chain(promise).collect(),
                series: lines.into_iter().map(|(y, line, _)| Series::new(time_s, y, line).times(1e3)).collect(),
                levels: level.into_iter().map(|level| (level, LIMIT)).collect(),
                ..Panel::over_time(time.clone(), Axis::padded(range, Y_TICKS), y_caption)
            },
        )
    });
    Ok(Figure { name: view.name.to_owned(), legend: vec![], rows: rows.into() })
}
