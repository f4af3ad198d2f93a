use schemars::JsonSchema;
use serde::Serialize;

use super::data::map_points;
use trocar_document::{Cell, DataTable, Number, Table, significant};
use trocar_scenario::population::{Arms, Delays, Draw, Tissues};
use trocar_scenario::unit_of;
use trocar_stability::{LIMITED, LimitQuantiles, Parameter, Population, Quantile};

const FACTORS: [&str; 7] = [
    "k_a_factor",
    "b_a_factor",
    "k_h_factor",
    "b_h_factor",
    "m_h_factor",
    "tissue_stiffness_factor",
    "tissue_damping_factor",
];

/// A limit is 0 if no value is stable, `inf` beyond the search, and empty for a delay given by the scenario.
pub(super) fn members(population: &Population) -> DataTable<'static> {
    let members = &population.members;
    let factors = |draw: &Draw| {
        let [k_a, b_a, k_h, b_h, m_h] = draw.arm;
        [k_a, b_a, k_h, b_h, m_h, draw.stiffness, draw.damping]
    };
    let mut table = DataTable::new("population");
    for (index, name) in FACTORS.into_iter().enumerate() {
        table = table.numbers(name, members.iter().map(|member| factors(&member.draw)[index]));
    }
    table = table
        .optional("delay_s", members.iter().map(|member| member.draw.delay_s))
        .flags("is_stable", members.iter().map(|member| member.is_stable));
    for (index, limit) in LIMITED.iter().enumerate() {
        table = table.numbers(format!("max_{}", limit.key()), members.iter().map(|member| member.limits[index]));
    }
    table
}

pub(super) fn map(population: &Population) -> DataTable<'static> {
    let map = &population.map;
    let points: Vec<(usize, usize)> = map_points(&map.x, &map.y).collect();
    let share = |(column, row): &(usize, usize)| map.share(*column, *row);
    DataTable::new("population_map")
        .numbers(map.x.parameter.key(), points.iter().map(|(column, _)| map.x.value(*column)))
        .numbers(map.y.parameter.key(), points.iter().map(|(_, row)| map.y.value(*row)))
        .numbers("stable_share", points.iter().map(|point| share(point).0))
        .numbers("low", points.iter().map(|point| share(point).1.0))
        .numbers("high", points.iter().map(|point| share(point).1.1))
}

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

pub(super) fn table(population: &Population) -> Table {
    let limits = &population.limits;
    let of_limit = |parameter: Parameter| (parameter.key(), format!("{}{}", parameter.key(), unit(parameter)));
    let columns = limits.iter().map(|of| of_limit(of.parameter));
    let columns = std::iter::once(("share", "share with a smaller limit".to_owned())).chain(columns);
    let mut table = Table::new("population_limits", "Limits over the population [95 % interval]", columns);
    for (index, one) in limits.first().into_iter().flat_map(|of| of.quantiles.iter().enumerate()) {
        let cells = limits.iter().map(|of| {
            let quantile = &of.quantiles[index];
            let (low, high) = quantile.interval;
            if [quantile.value, low, high].iter().all(|value| value.is_finite()) {
                return Cell::Interval(Number::si(quantile.value, ""), [low, high]);
            }
            Cell::Text(format!("{} [{}, {}]", limit(quantile.value), limit(low), limit(high)))
        });
        let share = Cell::Text(format!("{} %", significant(100.0 * one.share)));
        table.row(std::iter::once(share).chain(cells));
    }
    table
}

pub(super) fn lines(population: &Population) -> [String; 2] {
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

/// The limits over the population. A limit beyond the search range is `None`, with `is_beyond_search`.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct PopulationPart {
    /// Number of members.
    size: usize,
    stable_share: SharePart,
    /// The limit of each parameter.
    limits: Vec<LimitQuantilesPart>,
    smallest_found: WorstPart,
}

/// The share of members with a stable loop.
#[derive(Debug, Serialize, JsonSchema)]
struct SharePart {
    /// The share.
    value: f64,
    /// Its 95 % interval.
    interval: (f64, f64),
}

/// The limit of a parameter over the members.
#[derive(Debug, Serialize, JsonSchema)]
struct LimitQuantilesPart {
    /// Key of the parameter.
    parameter: &'static str,
    /// Quantiles of the limit, increasing, in the unit of the key.
    quantiles: Vec<QuantilePart>,
}

/// A quantile of a limit.
#[derive(Debug, Serialize, JsonSchema)]
struct QuantilePart {
    /// The share of the members with a smaller limit.
    share: f64,
    /// The quantile.
    value: Option<f64>,
    /// Its 95 % interval.
    interval: (Option<f64>, Option<f64>),
    /// True if the quantile is beyond the search range.
    is_beyond_search: bool,
}

/// The member with the smallest maximum stiffness, among all members and the corners of the range.
#[derive(Debug, Serialize, JsonSchema)]
struct WorstPart {
    /// Its maximum stable stiffness, in N/m.
    max_stiffness_n_per_m: Option<f64>,
    arm_factors: ArmFactors,
    /// Factor on the damping of the tissue.
    tissue_damping_factor: f64,
    /// Delay of each direction in s; `None` if the scenario gives it.
    delay_s: Option<f64>,
}

/// Factors on the parameters of the arm.
#[derive(Debug, Serialize, JsonSchema)]
struct ArmFactors {
    /// Factor on the stiffness of the arm.
    k_a: f64,
    /// Factor on the damping of the arm.
    b_a: f64,
    /// Factor on the stiffness of the hand.
    k_h: f64,
    /// Factor on the damping of the hand.
    b_h: f64,
    /// Factor on the mass of the hand.
    m_h: f64,
}

impl PopulationPart {
    pub(super) fn of(population: &Population) -> Self {
        let finite = |value: f64| Some(value).filter(|value| value.is_finite());
        let quantile = |one: &Quantile| QuantilePart {
            share: one.share,
            value: finite(one.value),
            interval: (finite(one.interval.0), finite(one.interval.1)),
            is_beyond_search: one.value.is_infinite(),
        };
        let limit = |of: &LimitQuantiles| LimitQuantilesPart {
            parameter: of.parameter.key(),
            quantiles: of.quantiles.iter().map(quantile).collect(),
        };
        let Draw { arm: [k_a, b_a, k_h, b_h, m_h], stiffness: _, damping, delay_s } = population.worst.draw;
        let (share, interval) = population.stable_share;
        Self {
            size: population.members.len(),
            stable_share: SharePart { value: share, interval },
            limits: population.limits.iter().map(limit).collect(),
            smallest_found: WorstPart {
                max_stiffness_n_per_m: finite(population.worst.stiffness_n_per_m),
                arm_factors: ArmFactors { k_a, b_a, k_h, b_h, m_h },
                tissue_damping_factor: damping,
                delay_s,
            },
        }
    }
}
