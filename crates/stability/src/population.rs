use super::limit::StabilityTester;
use super::shares::{ShareMap, share_interval};
use super::{Axis, ClosedLoop, LIMITED, LinearLoop, Parameter, Search, StabilityError, largest_stable};
use trocar_base::parallel::try_map;
use trocar_scenario::population::{DIMENSIONS, Draw, PopulationSettings};

const REACH: f64 = 30.0;
const POINTS: usize = 14;
const TOLERANCE: f64 = 1e-7;

const QUANTILES: [f64; 5] = [0.05, 0.25, 0.5, 0.75, 0.95];

const OF_STIFFNESS: usize = 6;

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Member {
    pub draw: Draw,
    pub is_stable: bool,
    /// 0 if no value is stable, infinite beyond the search. The delay's stable range begins at 0.
    pub limits: [f64; LIMITED.len()],
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Quantile {
    pub share: f64,
    pub value: f64,
    pub interval: (f64, f64),
}

#[derive(Debug, Clone, PartialEq)]
pub struct LimitQuantiles {
    pub parameter: Parameter,
    pub quantiles: Vec<Quantile>,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Worst {
    pub draw: Draw,
    /// 0 if no stiffness is stable, infinite beyond the search.
    pub stiffness_n_per_m: f64,
}

#[derive(Debug, Clone, PartialEq)]
pub struct Population {
    pub settings: PopulationSettings,
    pub members: Vec<Member>,
    pub stable_share: (f64, (f64, f64)),
    pub limits: Vec<LimitQuantiles>,
    /// A smaller stiffness may exist.
    pub worst: Worst,
    pub map: ShareMap,
}

pub(super) fn of_member(settings: &LinearLoop, draw: &Draw) -> LinearLoop {
    let mut other = settings.clone();
    let arm = &mut other.arm;
    let places =
        [&mut arm.k_a_n_per_m, &mut arm.b_a_n_s_per_m, &mut arm.k_h_n_per_m, &mut arm.b_h_n_s_per_m, &mut arm.m_h_kg];
    for (place, factor) in places.into_iter().zip(draw.arm) {
        *place *= factor;
    }
    other.stiffness_n_per_m *= draw.stiffness;
    other.damping_n_s_per_m *= draw.damping;
    if let Some(delay_s) = draw.delay_s {
        (other.forward_delay_s, other.backward_delay_s) = (delay_s, delay_s);
    }
    other.replace_tissue();
    other
}

fn near(parameter: Parameter, of_scenario: Option<f64>) -> Search {
    let usual = Search::of(parameter);
    match of_scenario.filter(|limit| limit.is_finite() && *limit > 0.0) {
        Some(limit) => Search { low: limit / REACH, high: limit * REACH, points: POINTS, tolerance: TOLERANCE },
        None => Search { tolerance: TOLERANCE, ..usual },
    }
}

/// Any delay is stable below this loop gain; the distance to 1 allows for the gain between points.
const SMALL_GAIN: f64 = 0.9;

fn limit(settings: &LinearLoop, parameter: Parameter, search: Search) -> Result<f64, StabilityError> {
    Ok(largest_stable(settings, parameter, search)?.largest().unwrap_or(0.0))
}

fn delay_limit(settings: &LinearLoop, search: Search) -> Result<f64, StabilityError> {
    let without = settings.with(Parameter::Delay, 0.0);
    let tester = StabilityTester::new(&without)?;
    let tick_s = settings.tick_s;
    let is_stable = |ticks: u64| tester.is_stable(&[(Parameter::Delay, ticks as f64 * tick_s)]);
    if !is_stable(0)? {
        return Ok(0.0);
    }
    if ClosedLoop::new(&without)?.max_gain()? < SMALL_GAIN {
        return Ok(f64::INFINITY);
    }
    let (mut below, mut above) = (0, 1);
    while is_stable(above)? {
        (below, above) = (above, 2 * above);
        if above as f64 * tick_s > search.high {
            return Ok(f64::INFINITY);
        }
    }
    while above - below > 1 {
        let middle = u64::midpoint(below, above);
        if is_stable(middle)? { below = middle } else { above = middle }
    }
    let range = (below as f64 * tick_s, above as f64 * tick_s);
    // A sample that waits for the next tick is late by a tick.
    if settings.waits_for_tick() {
        return Ok(range.0);
    }
    tester.boundary(Parameter::Delay, range, true, search.tolerance)
}

fn analysed(settings: &LinearLoop, searches: &[Search]) -> Result<(bool, [f64; LIMITED.len()]), StabilityError> {
    let closed = ClosedLoop::new(settings)?;
    let is_stable = closed.is_stable()?;
    // The loop gain of the paper's controller is proportional to both scales.
    let margin = if settings.link.is_baseline() { closed.margins()?.gain } else { None };
    let mut limits = [0.0; LIMITED.len()];
    for ((place, parameter), search) in limits.iter_mut().zip(LIMITED).zip(searches) {
        *place = match (parameter, margin) {
            (Parameter::ForceScale | Parameter::PositionScale, Some(f64::INFINITY)) => f64::INFINITY,
            (Parameter::ForceScale | Parameter::PositionScale, Some(factor)) => factor * settings.get(parameter),
            (Parameter::Delay, _) => delay_limit(settings, *search)?,
            _ => limit(settings, parameter, *search)?,
        };
    }
    Ok((is_stable, limits))
}

/// The ranks of the interval are `n p ± z √(n p (1 - p))`.
fn quantile(sorted: &[f64], share: f64) -> Quantile {
    let n = sorted.len() as f64;
    let at = |rank: f64| sorted[(rank.max(0.0) as usize).min(sorted.len() - 1)];
    let half = super::shares::CONFIDENCE * (n * share * (1.0 - share)).sqrt();
    Quantile {
        share,
        value: at((n * share).ceil() - 1.0),
        interval: (at((n * share - half).floor() - 1.0), at((n * share + half).ceil())),
    }
}

impl Population {
    pub fn of(
        settings: &LinearLoop,
        population: &PopulationSettings,
        seed: u64,
        (x, y): (&Axis, &Axis),
    ) -> Result<Self, StabilityError> {
        let scenario = LIMITED.map(|parameter| {
            largest_stable(settings, parameter, Search { tolerance: 1e-3, ..Search::of(parameter) })
                .map(|limit| near(parameter, limit.largest()))
        });
        let searches = scenario.into_iter().collect::<Result<Vec<Search>, _>>()?;
        let draws: Vec<Draw> = (0..population.size.max(1)).map(|index| population.drawn(seed, index)).collect();
        let members: Vec<Member> = try_map(draws.len(), |index| {
            let draw = draws[index];
            let (is_stable, limits) = analysed(&of_member(settings, &draw), &searches)?;
            Ok::<_, StabilityError>(Member { draw, is_stable, limits })
        })?;
        let of_stiffness = LIMITED.iter().position(|parameter| *parameter == Parameter::Stiffness).unwrap_or(0);
        let corners = corners(population);
        let corners: Vec<Worst> = try_map(corners.len(), |index| {
            let draw = corners[index];
            let settings = of_member(settings, &draw);
            let stiffness_n_per_m = limit(&settings, Parameter::Stiffness, searches[of_stiffness])?;
            Ok::<_, StabilityError>(Worst { draw, stiffness_n_per_m })
        })?;
        let drawn =
            members.iter().map(|member| Worst { draw: member.draw, stiffness_n_per_m: member.limits[of_stiffness] });
        let smaller = |a: Worst, b: Worst| if b.stiffness_n_per_m < a.stiffness_n_per_m { b } else { a };
        let first = corners[0];
        let worst = corners.into_iter().chain(drawn).fold(first, smaller);
        let of_limit = |(index, &parameter): (usize, &Parameter)| {
            let mut limits: Vec<f64> = members.iter().map(|member| member.limits[index]).collect();
            limits.sort_by(f64::total_cmp);
            LimitQuantiles { parameter, quantiles: QUANTILES.iter().map(|&share| quantile(&limits, share)).collect() }
        };
        let loops: Vec<LinearLoop> =
            draws.iter().take(ShareMap::MAX_LOOPS).map(|draw| of_member(settings, draw)).collect();
        Ok(Self {
            settings: *population,
            stable_share: share_interval(members.iter().filter(|member| member.is_stable).count(), members.len()),
            limits: LIMITED.iter().enumerate().map(of_limit).collect(),
            worst,
            map: ShareMap::of(&loops, (x, y))?,
            members,
        })
    }
}

fn corners(population: &PopulationSettings) -> Vec<Draw> {
    let is_drawn = population.is_drawn();
    let varied: Vec<usize> = (0..DIMENSIONS).filter(|&k| is_drawn[k] && k != OF_STIFFNESS).collect();
    let corner = |bits: u32| {
        let mut point = [0.5; DIMENSIONS];
        for (bit, &k) in varied.iter().enumerate() {
            point[k] = f64::from((bits >> bit) & 1);
        }
        population.at(&point)
    };
    (0..1 << varied.len()).map(corner).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quantile_lies_in_its_interval() {
        let values: Vec<f64> = (0..1000).map(f64::from).collect();
        for share in QUANTILES {
            let Quantile { value, interval, .. } = quantile(&values, share);
            assert!((value - (1000.0 * share - 1.0)).abs() < 1e-9);
            assert!(interval.0 < value && value < interval.1 && interval.1 - interval.0 < 70.0);
        }
    }
}
