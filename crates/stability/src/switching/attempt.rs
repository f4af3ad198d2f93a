use nalgebra::DMatrix;

use super::ascent;
use super::conditions::{Condition, Conditions, Count, Function, NamedMap, quantities};
use super::modes::Modes;
use super::scaling::Scales;
use super::settings::Phases;
use crate::StabilityError;
use crate::certificate::interval::middle;
use crate::certificate::{Certificate, Choice, unverified};
use crate::semidefinite::inequalities as sdp;

/// Far above the solver's accuracy of 1e-8.
const MIN_MARGIN: f64 = 1e-3;

const MIN_DRIVEN_MARGIN: f64 = 2e-6;

/// The verification covers the whole range.
const KNOWN_SHARES: [f64; 8] = [0.0, 0.005, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0];

const MAX_ROUNDS: usize = 5;

/// In ticks. With longer delays a function has a diagonal part, and a full part on `SEGMENTS` means of the delayed
/// positions.
const MAX_FULL_DELAY: usize = 4;
const SEGMENTS: usize = 4;

struct ForSolver<'a> {
    modes: &'a Modes,
    scales: Scales,
    maps: Vec<DMatrix<f64>>,
}

impl<'a> ForSolver<'a> {
    fn new(modes: &'a Modes, scales: Scales, maps: &[NamedMap]) -> Self {
        let scaled = |map: &NamedMap| middle(&scales.scaled(modes, &map.matrix, (map.from, map.to)));
        let maps = maps.iter().map(scaled).collect();
        Self { modes, scales, maps }
    }

    fn conditions(&self, condition: &Condition, known: &[u64]) -> Vec<sdp::Condition> {
        let plain = |maps: &[(usize, Count)], number: Option<u64>| {
            let mut all: Option<DMatrix<f64>> = None;
            for (map, count) in maps {
                let one = &self.maps[*map];
                let one = match (count, number) {
                    (Count::Each, Some(number)) => ascent::power(one, number),
                    _ => one.clone(),
                };
                all = Some(all.map_or_else(|| one.clone(), |before| before * &one));
            }
            all.unwrap_or_else(|| DMatrix::identity(0, 0))
        };
        let at = |number: Option<u64>| sdp::Condition {
            terms: condition
                .terms
                .iter()
                .map(|term| sdp::Term {
                    factor: 0.5 * (term.factor.low + term.factor.high),
                    unknown: term.unknown,
                    map: plain(&term.maps, number),
                })
                .collect(),
            weight: condition.weight,
        };
        match condition.counts {
            None => vec![at(None)],
            Some(_) => known.iter().map(|&number| at(Some(number))).collect(),
        }
    }

    fn unknown(&self, function: &Function) -> sdp::Unknown {
        let size = self.modes.size(function.space);
        let (n, delay) = (self.modes.states(), self.modes.delay());
        if delay <= MAX_FULL_DELAY || size < n {
            return sdp::Unknown { parts: vec![DMatrix::identity(size, size)] };
        }
        let machines = n - delay;
        let mut whole = DMatrix::zeros(machines + SEGMENTS + (size - n), size);
        for k in 0..machines {
            whole[(k, k)] = 1.0;
        }
        for k in 0..SEGMENTS {
            let (from, to) = (k * delay / SEGMENTS, (k + 1) * delay / SEGMENTS);
            for tick in from..to {
                whole[(machines + k, machines + tick)] = 1.0 / ((to - from) as f64).sqrt();
            }
        }
        for k in 0..size - n {
            whole[(machines + SEGMENTS + k, n + k)] = 1.0;
        }
        let single = (machines..n).map(|k| DMatrix::from_fn(1, size, |_, j| f64::from(u8::from(j == k))));
        sdp::Unknown { parts: std::iter::once(whole).chain(single).collect() }
    }
}

/// `None` if the solver fails.
pub(super) fn certify(modes: &Modes, phases: Phases, choice: Choice) -> Result<Option<Certificate>, StabilityError> {
    match attempt(modes, phases, choice) {
        Err(StabilityError::Solver { .. }) => Ok(None),
        attempt => attempt,
    }
}

pub(super) fn narrowed(
    (mut bound, mut certificate): (f64, Certificate),
    mut fails: f64,
    max_ratio: f64,
    certify: impl Fn(f64) -> Result<Option<Certificate>, StabilityError>,
) -> Result<(f64, Certificate), StabilityError> {
    while bound > max_ratio * fails {
        let middle = (bound * fails).sqrt();
        match certify(middle)? {
            Some(other) => (bound, certificate) = (middle, other),
            None => fails = middle,
        }
    }
    Ok((bound, certificate))
}

fn attempt(modes: &Modes, phases: Phases, choice: Choice) -> Result<Option<Certificate>, StabilityError> {
    let conditions = Conditions::new(modes, phases, choice);
    let scales = Scales::new(modes)?;
    let scales = match quantities(modes, choice) {
        Some(rows) => scales.with_quantities(modes, &rows),
        None => scales,
    };
    let for_solver = ForSolver::new(modes, scales, &conditions.maps);
    let unknowns: Vec<sdp::Unknown> = conditions.functions.iter().map(|one| for_solver.unknown(one)).collect();
    let mut known: Vec<Vec<u64>> = conditions.list.iter().map(|condition| shares(condition.counts)).collect();
    let enough = if choice.is_driven { MIN_DRIVEN_MARGIN } else { MIN_MARGIN };
    for _ in 0..MAX_ROUNDS {
        let all: Vec<sdp::Condition> = (conditions.list.iter().zip(&known))
            .flat_map(|(condition, known)| for_solver.conditions(condition, known))
            .collect();
        let Ok((functions, margin)) = sdp::solve(&unknowns, &all, Some(enough)) else { break };
        if margin < enough {
            break;
        }
        let scale = |space| for_solver.scales.of(modes, space);
        let certificate = conditions.certificate(modes, choice, scale, functions);
        let unverified: Vec<(usize, u64)> = unverified(&certificate).collect();
        if unverified.is_empty() {
            return Ok(Some(certificate));
        }
        let mut is_new = false;
        for (index, number) in unverified {
            if conditions.list[index].counts.is_some() && !known[index].contains(&number) {
                known[index].push(number);
                is_new = true;
            }
        }
        if !is_new {
            break;
        }
    }
    Ok(None)
}

fn shares(range: Option<(u64, u64)>) -> Vec<u64> {
    let Some((begin, end)) = range else { return vec![] };
    let mut numbers: Vec<u64> =
        KNOWN_SHARES.iter().map(|share| begin + (share * (end - begin) as f64).round() as u64).collect();
    numbers.dedup();
    numbers
}
