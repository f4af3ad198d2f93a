//! The worst sequences, with a tissue that can change at every tick.
//!
//! The growth over a cycle is linear in the tissue of each tick, so its maximum lies at a vertex of the range. A
//! forward and a backward pass give the derivatives; each tick takes the preferred vertex, as long as the result
//! improves (bang-bang ascent). The result is a lower bound of the maximum.

use nalgebra::{Complex, DMatrix, DVector};
use std::sync::Arc;

use super::modes::{Modes, Space};
use super::settings::Phases;
use crate::StabilityError;
use crate::semidefinite::times;
use trocar_base::interrupt;
use trocar_base::parallel::try_map;
use trocar_core::augmentation::cross_fade;
use trocar_lti::eigenvalues;

const LONG_RUN: usize = 20;

const MAX_STEPS: usize = 25;

const EXTRA_S: [f64; 2] = [0.0, 0.05];

/// Any shrinking gap is a mixture of such pulses.
const PULSES_S: [f64; 3] = [0.0, 0.15, 0.5];

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Cycle {
    pub held_ticks: u64,
    /// From the release until the gap closes.
    pub gap_ticks: u64,
    pub dwell_ticks: u64,
}

#[derive(Debug, Clone, PartialEq)]
pub struct Growth {
    /// A lower bound of the maximum.
    pub found: f64,
    pub cycle: Option<Cycle>,
    pub changes: usize,
}

pub(super) type Choices = Arc<Vec<DMatrix<f64>>>;

pub(super) struct Steps<'a> {
    modes: &'a Modes,
    pub(super) phases: Phases,
    pub(super) teleoperation: Choices,
    pub(super) freeze: Choices,
    pub(super) frozen: Choices,
    pub(super) release: Choices,
    pub(super) closed: Choices,
    pub(super) blends: Vec<Choices>,
}

impl<'a> Steps<'a> {
    pub(super) fn new(modes: &'a Modes, phases: Phases) -> Self {
        let each = |map: &dyn Fn(usize) -> DMatrix<f64>| Arc::new(modes.vertices().map(map).collect::<Vec<_>>());
        let frozen = if modes.is_frozen_map_unique() {
            Arc::new(vec![modes.frozen(0, 1.0)])
        } else {
            let pairs = modes.vertices().flat_map(|vertex| modes.shares().iter().map(move |share| (vertex, *share)));
            Arc::new(pairs.map(|(vertex, share)| modes.frozen(vertex, share)).collect())
        };
        let weight = |tick: u64| cross_fade((tick + 1) as f64 / phases.blend as f64);
        Self {
            modes,
            phases,
            teleoperation: each(&|vertex| modes.teleoperation(vertex)),
            freeze: Arc::new(vec![modes.freeze()]),
            frozen,
            release: if modes.has_unique_motion() {
                Arc::new(vec![modes.release(0)])
            } else {
                each(&|vertex| modes.release(vertex))
            },
            closed: Arc::new(vec![modes.closed()]),
            blends: (0..phases.blend).map(|tick| each(&|vertex| modes.blend(vertex, weight(tick)))).collect(),
        }
    }

    pub(super) fn modes(&self) -> &'a Modes {
        self.modes
    }

    fn cycle(&self, cycle: Cycle) -> Vec<Choices> {
        let mut steps = vec![Arc::clone(&self.teleoperation), Arc::clone(&self.freeze)];
        if self.frozen.len() == 1 {
            steps.push(Arc::new(vec![power(&self.frozen[0], cycle.held_ticks)]));
        } else {
            steps.extend((0..cycle.held_ticks).map(|_| Arc::clone(&self.frozen)));
        }
        steps.push(Arc::clone(&self.release));
        let closes = self.modes.gap_closes();
        let blending = if closes { self.phases.blend.max(cycle.gap_ticks) } else { self.phases.blend };
        for tick in 0..blending {
            if closes && tick == cycle.gap_ticks {
                steps.push(Arc::clone(&self.closed));
            }
            steps.push(Arc::clone(self.blends.get(tick as usize).unwrap_or(&self.teleoperation)));
        }
        if closes {
            steps.push(Arc::clone(&self.closed));
        }
        steps.extend((1..cycle.dwell_ticks).map(|_| Arc::clone(&self.teleoperation)));
        steps
    }
}

pub(super) fn power(a: &DMatrix<f64>, mut n: u64) -> DMatrix<f64> {
    let (mut result, mut base) = (DMatrix::identity(a.nrows(), a.nrows()), a.clone());
    while n > 0 {
        if n % 2 == 1 {
            result = times(&result, &base);
        }
        n /= 2;
        if n > 0 {
            base = times(&base, &base);
        }
    }
    result
}

type Dominant = (Complex<f64>, DVector<Complex<f64>>, DVector<Complex<f64>>);

fn dominant(matrix: &DMatrix<f64>) -> Result<Option<Dominant>, StabilityError> {
    if matrix.iter().any(|value| !value.is_finite()) {
        return Ok(None);
    }
    let values = eigenvalues(matrix)?;
    let Some(largest) = values.into_iter().max_by(|a, b| a.norm().total_cmp(&b.norm())) else { return Ok(None) };
    let n = matrix.nrows();
    let vector = |matrix: DMatrix<f64>| {
        let shift = largest * (1.0 + 1e-9) + 1e-300;
        let shifted = matrix.map(|value| Complex::new(value, 0.0)) - DMatrix::identity(n, n) * shift;
        let factors = shifted.lu();
        let mut vector = DVector::from_fn(n, |k, _| Complex::new(1.0 + 0.1 * k as f64, 0.3));
        for _ in 0..3 {
            vector = factors.solve(&vector)?;
            let size = vector.norm();
            if !(size.is_finite() && size > 0.0) {
                return None;
            }
            vector /= Complex::new(size, 0.0);
        }
        Some(vector)
    };
    let (Some(right), Some(left)) = (vector(matrix.clone()), vector(matrix.transpose())) else { return Ok(None) };
    Ok(Some((largest, right, left)))
}

fn product(steps: &[Choices], chosen: &[usize], narrow: &(DMatrix<f64>, DMatrix<f64>)) -> DMatrix<f64> {
    let mut all = narrow.0.clone();
    let is_same = |a: usize, b: usize| chosen[a] == chosen[b] && Arc::ptr_eq(&steps[a], &steps[b]);
    let mut at = 0;
    while at < steps.len() {
        let end = (at + 1..steps.len()).find(|&other| !is_same(at, other)).unwrap_or(steps.len());
        let map = &steps[at][chosen[at]];
        if end - at > LONG_RUN {
            all = times(&power(map, (end - at) as u64), &all);
        } else {
            for _ in at..end {
                all = times(map, &all);
            }
        }
        at = end;
    }
    times(&narrow.1, &all)
}

pub(super) fn radius(matrix: &DMatrix<f64>) -> Result<f64, StabilityError> {
    if matrix.iter().any(|value| !value.is_finite()) {
        return Ok(f64::INFINITY);
    }
    Ok(eigenvalues(matrix)?.into_iter().map(|value| value.norm()).fold(0.0, f64::max))
}

type Changes = Vec<(usize, usize, f64)>;

fn improve(
    chosen: &mut Vec<usize>,
    value: &mut f64,
    mut changes: Changes,
    evaluate: impl Fn(&[usize]) -> Result<f64, StabilityError>,
) -> Result<bool, StabilityError> {
    changes.sort_by(|a, b| b.2.total_cmp(&a.2));
    while !changes.is_empty() {
        interrupt::check();
        let mut other = chosen.clone();
        for &(tick, choice, _) in &changes {
            other[tick] = choice;
        }
        let result = evaluate(&other)?;
        if result > *value * (1.0 + 1e-9) {
            (*chosen, *value) = (other, result);
            return Ok(true);
        }
        changes.truncate(changes.len() / 4);
    }
    Ok(false)
}

fn ascend(modes: &Modes, steps: &[Choices], first: usize) -> Result<(f64, Vec<usize>), StabilityError> {
    let space = if modes.gap_closes() { Space::Loop } else { Space::LoopGap };
    let narrow = (modes.selection(space, Space::All), modes.selection(Space::All, space));
    let mut chosen: Vec<usize> = steps.iter().map(|step| first.min(step.len() - 1)).collect();
    let mut value = radius(&product(steps, &chosen, &narrow))?;
    for _ in 0..MAX_STEPS {
        interrupt::check();
        if !value.is_finite() {
            break;
        }
        let Some((eigenvalue, right, left)) = dominant(&product(steps, &chosen, &narrow))? else { break };
        // dλ = wᵀ dM v / wᵀ v, and d|λ| = Re(conj(λ) dλ) / |λ|.
        let complex = |matrix: &DMatrix<f64>| matrix.map(|value| Complex::new(value, 0.0));
        let phase = eigenvalue.conj() / (left.dot(&right) * eigenvalue.norm());
        let mut forward = vec![complex(&narrow.0) * &right];
        for (step, &choice) in steps.iter().zip(&chosen) {
            let next = apply(&step[choice], &forward[forward.len() - 1]);
            forward.push(next);
        }
        let mut back = complex(&narrow.1.transpose()) * &left;
        let mut changes = vec![];
        for tick in (0..steps.len()).rev() {
            let gain = |choice: usize| (back.dot(&apply(&steps[tick][choice], &forward[tick])) * phase).re;
            if steps[tick].len() > 1 {
                let present = gain(chosen[tick]);
                for choice in (0..steps[tick].len()).filter(|choice| *choice != chosen[tick]) {
                    let more = gain(choice) - present;
                    if more > 0.0 {
                        changes.push((tick, choice, more));
                    }
                }
            }
            back = apply_transposed(&steps[tick][chosen[tick]], &back);
        }
        if !improve(&mut chosen, &mut value, changes, |other| radius(&product(steps, other, &narrow)))? {
            break;
        }
    }
    Ok((value, chosen))
}

#[allow(clippy::needless_range_loop, reason = "adapters of iterators are calls if they are compiled in another unit")]
fn apply(matrix: &DMatrix<f64>, vector: &DVector<Complex<f64>>) -> DVector<Complex<f64>> {
    let rows = matrix.nrows();
    let mut product: DVector<Complex<f64>> = DVector::zeros(rows);
    let (all, to) = (matrix.as_slice(), product.as_mut_slice());
    for (j, &factor) in vector.as_slice().iter().enumerate() {
        let column = &all[j * rows..(j + 1) * rows];
        for i in 0..rows {
            to[i].re += factor.re * column[i];
            to[i].im += factor.im * column[i];
        }
    }
    product
}

#[allow(clippy::needless_range_loop, reason = "adapters of iterators are calls if they are compiled in another unit")]
fn apply_transposed(matrix: &DMatrix<f64>, vector: &DVector<Complex<f64>>) -> DVector<Complex<f64>> {
    let (rows, values) = (matrix.nrows(), vector.as_slice());
    DVector::from_fn(matrix.ncols(), |j, _| {
        let column = &matrix.as_slice()[j * rows..(j + 1) * rows];
        let (mut re, mut im) = (0.0, 0.0);
        for i in 0..rows {
            re += values[i].re * column[i];
            im += values[i].im * column[i];
        }
        Complex::new(re, im)
    })
}

pub(super) fn growth(steps: &Steps<'_>, dwell: u64) -> Result<Growth, StabilityError> {
    let Steps { modes, phases, .. } = steps;
    let ticks = |seconds: f64| (seconds / modes.tick_s).round() as u64;
    let (shortest, longest) = phases.held;
    let pulses: &[f64] = if modes.has_gap() && modes.gap_closes() { &PULSES_S } else { &PULSES_S[..1] };
    let mut tried = vec![];
    for held_ticks in if shortest == longest { vec![shortest] } else { vec![shortest, longest] } {
        for extra in EXTRA_S {
            for &pulse in pulses {
                let cycle = Cycle { held_ticks, gap_ticks: ticks(pulse).max(1), dwell_ticks: dwell + ticks(extra) };
                tried.extend(modes.vertices().map(|first| (cycle, first)));
            }
        }
    }
    let results: Vec<(f64, Cycle, usize)> = try_map(tried.len(), |index| {
        let (cycle, first) = tried[index];
        let (found, chosen) = ascend(modes, &steps.cycle(cycle), first)?;
        Ok::<_, StabilityError>((found, cycle, chosen.windows(2).filter(|pair| pair[0] != pair[1]).count()))
    })?;
    // The first of equal results, independent of the threads.
    let best = results.into_iter().reduce(|best, one| if one.0 > best.0 { one } else { best });
    Ok(best.map_or(Growth { found: 0.0, cycle: None, changes: 0 }, |(found, cycle, changes)| Growth {
        found,
        cycle: Some(cycle),
        changes,
    }))
}
