//! NSGA-II, an evolutionary search for a Pareto front under constraints (Deb et al., IEEE Trans. Evol. Comput. 6,
//! 2002).
//!
//! A point is *constraint-dominant* over another if it is feasible against infeasible, less violated among infeasible
//! points, or Pareto-dominant among feasible ones. Ties are broken by the crowding distance.
//!
//! Random numbers depend only on the seed, the generation and the index of the child, so a stored search continues with
//! the same results.

#[cfg(test)]
mod tests;
mod variation;
mod volume;

pub use variation::{Gene, child};
pub use volume::hypervolume;

#[derive(Debug, Clone, PartialEq)]
pub struct Point {
    /// Minimised; not used for an infeasible point.
    pub objectives: Vec<f64>,
    /// Sum of the relative violations: 0 if feasible, infinite for the worst.
    pub violation: f64,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Standing {
    pub rank: usize,
    /// Infinite for a point with an extreme objective.
    pub crowding: f64,
}

impl Standing {
    pub fn is_preferred_to(&self, other: &Self) -> bool {
        self.rank < other.rank || self.rank == other.rank && self.crowding > other.crowding
    }
}

/// True if `a` is at most `b` in every objective and below it in one.
pub fn pareto_dominates(a: &[f64], b: &[f64]) -> bool {
    a.iter().zip(b).all(|(a, b)| a <= b) && a.iter().zip(b).any(|(a, b)| a < b)
}

pub fn dominates(a: &Point, b: &Point) -> bool {
    match (a.violation > 0.0, b.violation > 0.0) {
        (false, false) => pareto_dominates(&a.objectives, &b.objectives),
        (true, true) => a.violation < b.violation,
        (is_violated, _) => !is_violated,
    }
}

pub fn standings(points: &[Point]) -> Vec<Standing> {
    let mut standings = vec![Standing { rank: 0, crowding: 0.0 }; points.len()];
    let mut dominated_by: Vec<usize> =
        points.iter().map(|point| points.iter().filter(|other| dominates(other, point)).count()).collect();
    let mut left: Vec<usize> = (0..points.len()).collect();
    let mut rank = 0;
    while !left.is_empty() {
        let (front, rest): (Vec<usize>, Vec<usize>) = left.iter().partition(|&&index| dominated_by[index] == 0);
        for &better in &front {
            rest.iter().filter(|&&index| dominates(&points[better], &points[index])).for_each(|&index| {
                dominated_by[index] -= 1;
            });
        }
        for (&index, crowding) in front.iter().zip(crowding(points, &front)) {
            standings[index] = Standing { rank, crowding };
        }
        left = rest;
        rank += 1;
    }
    standings
}

/// Distance between the two neighbours as a share of the objective's range, summed over the objectives.
fn crowding(points: &[Point], front: &[usize]) -> Vec<f64> {
    let objectives = front.iter().map(|&index| points[index].objectives.len()).min().unwrap_or(0);
    let mut distances = vec![0.0_f64; front.len()];
    for objective in 0..objectives {
        let value = |place: usize| points[front[place]].objectives[objective];
        let mut order: Vec<usize> = (0..front.len()).collect();
        order.sort_by(|a, b| value(*a).total_cmp(&value(*b)));
        let (Some(&first), Some(&last)) = (order.first(), order.last()) else { continue };
        let range = value(last) - value(first);
        distances[first] = f64::INFINITY;
        distances[last] = f64::INFINITY;
        if range > 0.0 && range.is_finite() {
            for around in order.windows(3) {
                distances[around[1]] += (value(around[2]) - value(around[0])) / range;
            }
        }
    }
    distances
}

/// Preferred points first; equal standings by index.
pub fn survivors(points: &[Point], count: usize) -> Vec<usize> {
    let standings = standings(points);
    let mut order: Vec<usize> = (0..points.len()).collect();
    order.sort_by(|&a, &b| {
        let (a, b) = (standings[a], standings[b]);
        a.rank.cmp(&b.rank).then(b.crowding.total_cmp(&a.crowding))
    });
    order.truncate(count);
    order
}

pub fn front(points: &[Point]) -> Vec<usize> {
    let is_feasible = |point: &&Point| point.violation <= 0.0;
    let on_front = |point: &Point| {
        is_feasible(&point)
            && !points.iter().filter(is_feasible).any(|other| pareto_dominates(&other.objectives, &point.objectives))
    };
    (0..points.len()).filter(|&index| on_front(&points[index])).collect()
}

/// At most `count` points, ascending: `first`, the extremes, then repeatedly the point farthest from all chosen ones.
pub fn spread(points: &[Point], front: &[usize], first: Option<usize>, count: usize) -> Vec<usize> {
    let scaled = scaled(points, front);
    let mut chosen: Vec<usize> = front.iter().position(|index| first == Some(*index)).into_iter().collect();
    let objectives = scaled.first().map_or(0, Vec::len);
    let lowest =
        |objective: usize| (0..front.len()).min_by(|a, b| scaled[*a][objective].total_cmp(&scaled[*b][objective]));
    for place in (0..objectives).filter_map(lowest) {
        if !chosen.contains(&place) && chosen.len() < count {
            chosen.push(place);
        }
    }
    let distance =
        |a: usize, b: usize| -> f64 { scaled[a].iter().zip(&scaled[b]).map(|(a, b)| (a - b) * (a - b)).sum() };
    while chosen.len() < count.min(front.len()) {
        let nearest = |place: usize| chosen.iter().map(|&other| distance(place, other)).fold(f64::INFINITY, f64::min);
        let rest = (0..front.len()).filter(|place| !chosen.contains(place));
        // The first of equal points, independent of rounding.
        let farthest = rest.map(|place| (nearest(place), place)).max_by(|a, b| a.0.total_cmp(&b.0).then(b.1.cmp(&a.1)));
        let Some((_, place)) = farthest else { break };
        chosen.push(place);
    }
    let mut indices: Vec<usize> = chosen.into_iter().map(|place| front[place]).collect();
    indices.sort_unstable();
    indices
}

/// Closest to the ideal point.
pub fn knee(points: &[Point], front: &[usize]) -> Option<usize> {
    let distance = |scaled: &Vec<f64>| scaled.iter().map(|share| share * share).sum::<f64>();
    let distances: Vec<f64> = scaled(points, front).iter().map(distance).collect();
    let nearest = (0..front.len()).min_by(|a, b| distances[*a].total_cmp(&distances[*b]));
    nearest.map(|place| front[place])
}

/// Shares of the objectives' ranges on the front; 0 for an objective without a range.
pub fn scaled(points: &[Point], front: &[usize]) -> Vec<Vec<f64>> {
    let objectives = front.first().map_or(0, |&index| points[index].objectives.len());
    let range = |objective: usize| {
        let values = || front.iter().map(|&index| points[index].objectives[objective]);
        (values().fold(f64::INFINITY, f64::min), values().fold(f64::NEG_INFINITY, f64::max))
    };
    let ranges: Vec<(f64, f64)> = (0..objectives).map(range).collect();
    let share = |(value, (low, high)): (&f64, &(f64, f64))| if high > low { (value - low) / (high - low) } else { 0.0 };
    front.iter().map(|&index| points[index].objectives.iter().zip(&ranges).map(share).collect()).collect()
}
