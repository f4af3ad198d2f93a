//! The certificate. A solver finds it; interval arithmetic verifies it.

use nalgebra::DMatrix;

use super::ascent;
use super::conditions::{Choice, Condition, Conditions, Count, Focus, Function, NamedMap, Term};
use super::interval::{Enclosure, exact, is_positive_definite, middle, power, product, sum, transpose};
use super::modes::{Modes, Space};
use super::scaling::Scales;
use super::sdp;
use super::settings::Phases;
use crate::StabilityError;

/// Minimum margin of a certificate: far above the solver's accuracy of 1e-8, so every computer finds the same dwell.
const MIN_MARGIN: f64 = 1e-3;

/// Positions in a condition's range of ticks for the solver. The verification covers the whole range.
const KNOWN_SHARES: [f64; 8] = [0.0, 0.005, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0];

/// Maximum calls of the solver. Each adds the tick counts that failed verification.
const MAX_ROUNDS: usize = 5;

/// Maximum delay in ticks for which a function has a full matrix. With a longer delay, it has a diagonal part, and a
/// full part on `SEGMENTS` means of the delayed positions.
const MAX_FULL_DELAY: usize = 4;
const SEGMENTS: usize = 4;

/// A quadratic function of a certificate.
#[derive(Debug, Clone)]
pub struct Lyapunov {
    /// The name, with the number of its node in time.
    pub name: String,
    /// `P̂` in `V = zᵀ P̂ z`, with the scaled states `z = S⁻¹ x`.
    pub matrix: DMatrix<f64>,
    /// Index of the space in [`Certificate::spaces`].
    pub space: usize,
}

/// The states of a phase.
#[derive(Debug, Clone)]
pub struct StateSpace {
    /// The name of the space.
    pub name: String,
    /// Name and unit of each state, in order.
    pub states: Vec<(String, &'static str)>,
    /// `S`, from scaled states to states.
    pub scale: DMatrix<f64>,
}

/// A map between the states of two spaces.
#[derive(Debug, Clone)]
pub struct StateMap {
    /// The name of the map.
    pub name: String,
    /// Index of the space of the argument.
    pub from: usize,
    /// Index of the space of the result.
    pub to: usize,
    /// The matrix.
    pub matrix: DMatrix<f64>,
}

/// `f Mᵀ P M` with `M` a product of maps.
#[derive(Debug, Clone)]
pub struct Summand {
    /// `f`.
    pub factor: f64,
    /// Index of the function.
    pub function: usize,
    /// Indices of the maps, the first one applied last; true for the map with the power of the inequality.
    pub maps: Vec<(usize, bool)>,
}

/// A sum that must be positive definite.
#[derive(Debug, Clone)]
pub struct Inequality {
    /// The purpose of the inequality.
    pub name: &'static str,
    /// Index of the space of its rows.
    pub rows: usize,
    /// The first and the last power for which the inequality holds.
    pub powers: Option<(u64, u64)>,
    /// The terms.
    pub terms: Vec<Summand>,
}

/// Lyapunov functions that prove the decay of every sequence of events, or a bound of a quantity.
#[derive(Debug, Clone)]
pub struct Certificate {
    /// Required ticks of teleoperation between two events.
    pub dwell_ticks: u64,
    /// Verified upper bound, at most 1, of the ratio of `V` at the beginnings of consecutive events.
    pub contraction: f64,
    /// Verified factor of `V` per tick of teleoperation, at most 1.
    pub decay: f64,
    /// The solver's common margin of all scaled conditions; not necessarily the maximum.
    pub margin: f64,
    /// Number of verified conditions, counting each power.
    pub conditions: u64,
    /// Index of the function at the beginning of events.
    pub at_events: usize,
    /// The states of each phase.
    pub spaces: Vec<StateSpace>,
    /// The functions.
    pub functions: Vec<Lyapunov>,
    /// The maps.
    pub maps: Vec<StateMap>,
    /// The verified inequalities.
    pub inequalities: Vec<Inequality>,
}

impl Certificate {
    /// A bound of the growth per event for a dwell that is at least the certificate's.
    #[must_use]
    pub fn growth_after(&self, dwell_ticks: u64) -> f64 {
        let longer = dwell_ticks.saturating_sub(self.dwell_ticks);
        // The factor covers the roundings of the power.
        (self.contraction * self.decay.powf(longer as f64)).sqrt() * (1.0 + 1e-12)
    }

    /// Returns `P` of the function at the beginning of events, for unscaled states.
    #[must_use]
    pub fn p_at_events(&self) -> DMatrix<f64> {
        let function = &self.functions[self.at_events];
        let scale = &self.spaces[function.space].scale;
        let inverse = scale.clone().try_inverse().unwrap_or_else(|| scale.clone());
        let plain = inverse.transpose() * &function.matrix * inverse;
        (&plain + plain.transpose()) * 0.5
    }
}

pub(super) struct Enclosures<'a> {
    modes: &'a Modes,
    scales: Scales,
    maps: Vec<Enclosure>,
}

/// `M^n R` for all `n` of a range, as products of a few powers, which limits the rounding.
pub(super) struct Powers {
    begin: u64,
    /// `M^k` for `k` below the stride.
    steps: Vec<Enclosure>,
    /// `M^n R` for every whole number of strides above the first `n`.
    leaps: Vec<Enclosure>,
}

/// Each power is the product of two powers of half its exponent.
pub(super) fn first_powers(base: &Enclosure, count: usize) -> Vec<Enclosure> {
    let mut all = vec![power(base, 0), base.clone()];
    for n in 2..count {
        all.push(product(&all[n / 2], &all[n - n / 2]));
    }
    all.truncate(count);
    all
}

impl Powers {
    pub(super) fn new(base: &Enclosure, (begin, end): (u64, u64), right: &Enclosure) -> Self {
        let stride = ((end - begin) as f64).sqrt() as usize + 1;
        let leaps = (end - begin) as usize / stride + 1;
        let to_begin = product(&power(base, begin), right);
        let leaps =
            first_powers(&power(base, stride as u64), leaps).iter().map(|leap| product(leap, &to_begin)).collect();
        Self { begin, steps: first_powers(base, stride), leaps }
    }

    pub(super) fn get(&self, n: u64) -> Enclosure {
        let (stride, n) = (self.steps.len(), (n - self.begin) as usize);
        product(&self.steps[n % stride], &self.leaps[n / stride])
    }
}

impl<'a> Enclosures<'a> {
    fn new(modes: &'a Modes, scales: Scales, maps: &[NamedMap]) -> Self {
        let scaled = |map: &NamedMap| scales.scaled(modes, &map.matrix, map.is_exact, (map.from, map.to));
        let maps = maps.iter().map(scaled).collect();
        Self { modes, scales, maps }
    }

    fn chain(&self, maps: &[(usize, Count)]) -> Option<Enclosure> {
        let (first, others) = maps.split_first()?;
        Some(others.iter().fold(self.maps[first.0].clone(), |all, (map, _)| product(&all, &self.maps[*map])))
    }

    #[allow(clippy::type_complexity, reason = "four parts that are always destructured at once")]
    fn counted<'c>(
        &self,
        condition: &'c Condition,
    ) -> Option<(&'c Term, Option<Enclosure>, &Enclosure, Option<Enclosure>)> {
        condition.terms.iter().find_map(|term| {
            let at = term.maps.iter().position(|(_, count)| *count == Count::Each)?;
            let (before, after) = (self.chain(&term.maps[..at]), self.chain(&term.maps[at + 1..]));
            Some((term, before, &self.maps[term.maps[at].0], after))
        })
    }

    /// The first number in the range for which a condition is not verified; 0 without a range.
    fn failure(&self, condition: &Condition, functions: &[DMatrix<f64>]) -> Option<u64> {
        let congruence = |term: &Term, map: Option<Enclosure>| {
            let function = exact(&functions[term.unknown]);
            let mut value = match map {
                Some(map) => product(&transpose(&map), &product(&function, &map)),
                None => function,
            };
            for entry in value.iter_mut().flatten() {
                *entry = *entry * term.factor;
            }
            value
        };
        let is_fixed = |term: &&Term| term.maps.iter().all(|(_, count)| *count == Count::Once);
        let fixed = condition.terms.iter().filter(is_fixed).map(|term| congruence(term, self.chain(&term.maps)));
        let fixed = fixed.reduce(|a, b| sum(&a, &b)).unwrap_or_default();
        let (Some((begin, end)), Some((term, before, base, after))) = (condition.counts, self.counted(condition))
        else {
            return (!is_positive_definite(&fixed)).then_some(0);
        };
        let inner = congruence(term, before);
        let powers = Powers::new(base, (begin, end), &after.unwrap_or_else(|| power(base, 0)));
        (begin..=end).find(|&n| {
            let map = powers.get(n);
            let value = product(&transpose(&map), &product(&inner, &map));
            !is_positive_definite(&sum(&fixed, &value))
        })
    }

    fn for_solver(&self, condition: &Condition, known: &[u64]) -> Vec<sdp::Condition> {
        let plain = |maps: &[(usize, Count)], number: Option<u64>| {
            let mut all: Option<DMatrix<f64>> = None;
            for (map, count) in maps {
                let one = middle(&self.maps[*map]);
                let one = match (count, number) {
                    (Count::Each, Some(number)) => ascent::power(&one, number),
                    _ => one,
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

pub(super) fn attempt(
    modes: &Modes,
    phases: Phases,
    choice: Choice,
    focus: Option<&Focus>,
) -> Result<Option<Certificate>, StabilityError> {
    let conditions = Conditions::new(modes, phases, choice, focus);
    let scales = Scales::new(modes)?;
    let scales = focus.map_or_else(|| scales.clone(), |focus| scales.with_focus(modes, focus));
    let enclosures = Enclosures::new(modes, scales, &conditions.maps);
    let unknowns: Vec<sdp::Unknown> = conditions.functions.iter().map(|one| enclosures.unknown(one)).collect();
    let mut known: Vec<Vec<u64>> = conditions.list.iter().map(|condition| shares(condition.counts)).collect();
    for _ in 0..MAX_ROUNDS {
        let for_solver: Vec<sdp::Condition> = (conditions.list.iter().zip(&known))
            .flat_map(|(condition, known)| enclosures.for_solver(condition, known))
            .collect();
        let Ok((functions, margin)) = sdp::solve(&unknowns, &for_solver, Some(MIN_MARGIN)) else { break };
        if margin < MIN_MARGIN {
            break;
        }
        let mut fails_in_a_range = false;
        let mut fails = false;
        for (condition, known) in conditions.list.iter().zip(&mut known) {
            if let Some(number) = enclosures.failure(condition, &functions) {
                fails = true;
                if condition.counts.is_some() && !known.contains(&number) {
                    known.push(number);
                    fails_in_a_range = true;
                }
            }
        }
        if !fails {
            return Ok(Some(build(&conditions, &enclosures, choice, &functions, margin)));
        }
        if !fails_in_a_range {
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

fn build(
    conditions: &Conditions,
    enclosures: &Enclosures<'_>,
    choice: Choice,
    functions: &[DMatrix<f64>],
    margin: f64,
) -> Certificate {
    let mut spaces: Vec<Space> = vec![];
    let mut place = |space: Space| {
        spaces.iter().position(|known| *known == space).unwrap_or_else(|| {
            spaces.push(space);
            spaces.len() - 1
        })
    };
    let of_functions: Vec<Lyapunov> = (conditions.functions.iter().zip(functions))
        .map(|(function, matrix)| Lyapunov {
            name: function.name.clone(),
            matrix: matrix.clone(),
            space: place(function.space),
        })
        .collect();
    let maps: Vec<StateMap> = (conditions.maps.iter())
        .map(|map| StateMap {
            name: map.name.clone(),
            from: place(map.from),
            to: place(map.to),
            matrix: map.matrix.clone(),
        })
        .collect();
    let summand = |term: &Term| Summand {
        factor: 0.5 * (term.factor.low + term.factor.high),
        function: term.unknown,
        maps: term.maps.iter().map(|(map, count)| (*map, *count == Count::Each)).collect(),
    };
    let inequalities: Vec<Inequality> = (conditions.list.iter())
        .map(|condition| Inequality {
            name: condition.name,
            rows: place(condition.rows),
            powers: condition.counts,
            terms: condition.terms.iter().map(summand).collect(),
        })
        .collect();
    let modes = enclosures.modes;
    let spaces = spaces
        .into_iter()
        .map(|space| StateSpace {
            name: format!("{space:?}"),
            states: modes.names(space),
            scale: enclosures.scales.of(modes, space),
        })
        .collect();
    Certificate {
        dwell_ticks: choice.dwell,
        contraction: choice.contraction,
        decay: conditions.decay,
        margin,
        conditions: conditions.list.iter().map(|one| one.counts.map_or(1, |(begin, end)| end - begin + 1)).sum(),
        at_events: conditions.at_events,
        spaces,
        functions: of_functions,
        maps,
        inequalities,
    }
}
