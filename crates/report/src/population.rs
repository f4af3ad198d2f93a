//! Limits over a population as CSV, JSON, text and figure.

use std::fmt::Write as _;

use serde_json::{Value as Json, json};

use super::figures::{self, AxisView, HeatView};
use super::number::significant;
use super::pictures::{PictureError, keep};
use super::tables::shortest;
use super::{Folder, Table};
use trocar_scenario::population::{Arms, Delays, Draw, Tissues};
use trocar_scenario::unit_of;
use trocar_stability::{Axis, LIMITED, Parameter, Population, Spacing};

/// The columns of what is drawn.
const DRAWN: &str =
    "k_a_factor,b_a_factor,k_h_factor,b_h_factor,m_h_factor,tissue_stiffness_factor,tissue_damping_factor,delay_s";

/// Returns `population.csv`: a row per member. A limit is 0 if no value is stable, and `inf` beyond the search range; a
/// delay that is the scenario's is empty.
#[must_use]
pub fn population_csv(population: &Population) -> String {
    let limits: Vec<String> = LIMITED.iter().map(|limit| format!("max_{}", limit.key())).collect();
    let mut text = format!("{DRAWN},is_stable,{}\n", limits.join(","));
    for member in &population.members {
        let Draw { arm, stiffness, damping, delay_s } = member.draw;
        let factors: Vec<String> = arm.into_iter().chain([stiffness, damping]).map(shortest).collect();
        let delay = delay_s.map_or(String::new(), shortest);
        let limits = member.limits.map(shortest).join(",");
        let _ = writeln!(text, "{},{delay},{},{limits}", factors.join(","), u8::from(member.is_stable));
    }
    text
}

/// Returns `population_map.csv`: the share of members that is stable, with its 95 % interval.
#[must_use]
pub fn population_map_csv(population: &Population) -> String {
    let map = &population.map;
    let mut text = format!("{},{},stable_share,low,high\n", map.x.parameter.key(), map.y.parameter.key());
    for row in 0..map.y.count {
        for column in 0..map.x.count {
            let (share, (low, high)) = map.share(column, row);
            let cells = [map.x.value(column), map.y.value(row), share, low, high].map(shortest);
            let _ = writeln!(text, "{}", cells.join(","));
        }
    }
    text
}

/// What is drawn, in words.
fn drawn(population: &Population) -> String {
    let settings = &population.settings;
    let parts = [
        (settings.arms != Arms::None, "arms"),
        (settings.tissues != Tissues::None, "tissues"),
        (settings.delays != Delays::None, "delays"),
    ];
    let parts: Vec<&str> = parts.into_iter().filter(|(is_drawn, _)| *is_drawn).map(|(_, what)| what).collect();
    match parts.as_slice() {
        [] => "loops".to_owned(),
        [all @ .., last] if !all.is_empty() => format!("{} and {last}", all.join(", ")),
        all => all.join(""),
    }
}

fn unit(parameter: Parameter) -> String {
    unit_of(parameter.key()).map_or(String::new(), |unit| format!(" ({unit})"))
}

fn limit(value: f64) -> String {
    if value.is_finite() { significant(value) } else { "beyond search".to_owned() }
}

/// Returns the quantiles of the limits as a table.
pub(super) fn population_table(population: &Population) -> Table {
    let heads = population.limits.iter().map(|of| format!("{}{}", of.parameter.key(), unit(of.parameter)));
    let mut table = Table::new(std::iter::once("share with a smaller limit".to_owned()).chain(heads));
    for (index, one) in population.limits.first().into_iter().flat_map(|of| of.quantiles.iter().enumerate()) {
        let cells = population.limits.iter().map(|of| {
            let quantile = &of.quantiles[index];
            let (low, high) = quantile.interval;
            format!("{} [{}, {}]", limit(quantile.value), limit(low), limit(high))
        });
        table.row(std::iter::once(format!("{} %", significant(100.0 * one.share))).chain(cells));
    }
    table
}

/// Returns the sentences about a population: the share that is stable, and the smallest limit.
pub(super) fn population_lines(population: &Population) -> [String; 2] {
    let (share, (low, high)) = population.stable_share;
    let of = population.members.len();
    let stable = format!(
        "population of {of} {}: the loop is stable with {:.1} % of them (95 % interval {:.1} to {:.1} %)",
        drawn(population),
        100.0 * share,
        100.0 * low,
        100.0 * high,
    );
    let worst = population.worst.stiffness_n_per_m;
    let worst = if worst.is_finite() { format!("{} N/m", significant(worst)) } else { "beyond the search".to_owned() };
    [stable, format!("smallest maximum stiffness found in the whole range: {worst}")]
}

/// Returns the limits of a population as text.
#[must_use]
pub fn population_text(population: &Population) -> String {
    let [stable, worst] = population_lines(population);
    format!("{stable}\n{}{worst}\n", population_table(population))
}

/// Returns a population for `stability.json`. A limit beyond the search range is `null`, with `is_beyond_search`.
pub(super) fn population_json(population: &Population) -> Json {
    let value = |value: f64| json!(Some(value).filter(|value| value.is_finite()));
    let limits: Vec<Json> = population
        .limits
        .iter()
        .map(|of| {
            let quantiles = of.quantiles.iter().map(|one| {
                json!({
                    "share": one.share,
                    "value": value(one.value),
                    "interval": [value(one.interval.0), value(one.interval.1)],
                    "is_beyond_search": one.value.is_infinite(),
                })
            });
            json!({ "parameter": of.parameter.key(), "quantiles": quantiles.collect::<Vec<_>>() })
        })
        .collect();
    let Draw { arm, stiffness: _, damping, delay_s } = population.worst.draw;
    let (share, interval) = population.stable_share;
    json!({
        "size": population.members.len(),
        "stable_share": { "value": share, "interval": interval },
        "limits": limits,
        "smallest_found": {
            "max_stiffness_n_per_m": value(population.worst.stiffness_n_per_m),
            "arm_factors": { "k_a": arm[0], "b_a": arm[1], "k_h": arm[2], "b_h": arm[3], "m_h": arm[4] },
            "tissue_damping_factor": damping,
            "delay_s": delay_s,
        },
    })
}

/// Writes the figure `population`: the share of members that is stable over the axes of the map.
///
/// # Errors
/// [`PictureError`].
pub fn population_picture(folder: &Folder, name: &str, population: &Population) -> Result<(), PictureError> {
    let map = &population.map;
    let values = |axis: &Axis| (0..axis.count).map(|index| axis.value(index)).collect::<Vec<f64>>();
    let axis = |axis: &Axis| AxisView { name: axis.parameter.caption(), log: axis.spacing == Spacing::Logarithmic };
    let shares: Vec<f64> = map.stable.iter().map(|&stable| 100.0 * f64::from(stable) / map.of as f64).collect();
    let figure = figures::heat_map(&HeatView {
        name,
        caption: "Share of the population that is stable (%)",
        axes: [axis(&map.x), axis(&map.y)],
        x: values(&map.x),
        y: values(&map.y),
        means: &shares,
    })?;
    keep(folder, "population", &figure)
}
