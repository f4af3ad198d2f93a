//! 95 % intervals from residuals that are correlated in time.

use std::ops::Range;

use nalgebra::{DMatrix, DVector};

use crate::actuator::Bounded;
use crate::problem::Problem;
use crate::system::System;

/// Residuals are correlated within a block; blocks count as independent.
pub(crate) const BLOCKS: usize = 12;

/// Relative to the value or its start.
const STEP: f64 = 1e-3;

/// 97.5 % quantile of Student's t, within 2 % from 4 degrees of freedom on (two terms of its expansion in 1/n).
pub(crate) fn student(freedom: f64) -> f64 {
    let n = freedom.max(4.0);
    let z: f64 = 1.959_964;
    z + (z.powi(3) + z) / (4.0 * n) + (5.0 * z.powi(5) + 16.0 * z.powi(3) + 3.0 * z) / (96.0 * n * n)
}

/// `recording` is the index of its recording in the later problem.
pub(crate) struct Earlier<S: System> {
    pub(crate) problem: Problem<S>,
    pub(crate) recording: usize,
}

struct Linearised {
    errors: Vec<f64>,
    /// Derivatives by each unknown times its step, so the columns have similar magnitudes.
    columns: Vec<Vec<f64>>,
}

impl Linearised {
    fn of<S: System>(problem: &Problem<S>, model: &S::Model, steps: &[(S::Unknown, f64)]) -> Self {
        let errors = problem.system().errors(model);
        let column = |(unknown, step): &(S::Unknown, f64)| {
            let mut moved = model.clone();
            S::set(*unknown, &mut moved, S::value(*unknown, model) + step);
            problem.system().errors(&moved).iter().zip(&errors).map(|(moved, here)| moved - here).collect()
        };
        let columns = steps.iter().map(column).collect();
        Self { errors, columns }
    }

    /// `Σ J_i r_i`, enlarged for the fitted unknowns.
    fn scores<S: System>(&self, problem: &Problem<S>) -> Vec<DVector<f64>> {
        let blocks = blocks(problem);
        let share = (blocks.len() as f64 / freedom(problem)).sqrt();
        let score = |block: Range<usize>| {
            let gradient = self.columns.iter().map(|column| dot(&column[block.clone()], &self.errors[block.clone()]));
            DVector::from_iterator(self.columns.len(), gradient) * share
        };
        blocks.into_iter().map(score).collect()
    }
}

/// Blocks minus unknowns.
fn freedom<S: System>(problem: &Problem<S>) -> f64 {
    ((BLOCKS * problem.system().lengths().len()) as f64 - problem.free().len() as f64).max(1.0)
}

/// Returns first the unknowns that an earlier problem fixed, then the free ones; an undetermined unknown has an
/// infinite interval.
///
/// The covariance is the sandwich `A⁻¹ M A⁻ᵀ`: A contains the derivatives of the gradients (`JᵀJ` in a single problem),
/// M the sum over blocks of their outer products. The later gradient also depends on the fixed unknowns, so their
/// errors enlarge the later intervals (Newey and McFadden 1994, section 6). Priors count as observations.
pub(crate) fn intervals<S: System>(
    problem: &Problem<S>,
    model: &S::Model,
    start: &S::Model,
    earlier: Option<&Earlier<S>>,
) -> Vec<(S::Unknown, Bounded)> {
    let system = problem.system();
    let step = |unknown: &S::Unknown| {
        let size = S::value(*unknown, model).abs().max(0.1 * S::value(*unknown, start).abs());
        (*unknown, STEP * size.max(0.1 * system.expected(*unknown).map_or(0.0, |(_, sd)| sd)))
    };
    let free: Vec<(S::Unknown, f64)> = problem.free().iter().map(step).collect();
    let later = Linearised::of(problem, model, &free);
    let first: Vec<(S::Unknown, f64)> = earlier.map_or(vec![], |one| one.problem.free().iter().map(step).collect());
    let (before, all) = (first.len(), first.len() + free.len());
    let mut slopes = DMatrix::zeros(all, all);
    let mut meat = DMatrix::zeros(all, all);
    let mut scores: Vec<DVector<f64>> =
        later.scores(problem).into_iter().map(|score| score.insert_rows(0, before, 0.0)).collect();
    for (i, row) in later.columns.iter().enumerate() {
        for (j, column) in later.columns.iter().enumerate() {
            slopes[(before + i, before + j)] = dot(row, column);
        }
    }
    if let Some(Earlier { problem: early, recording }) = earlier {
        let early_model = early.model();
        let alone = Linearised::of(early, &early_model, &first);
        for (k, score) in alone.scores(early).into_iter().enumerate() {
            scores[BLOCKS * recording + k].rows_mut(0, before).copy_from(&score);
        }
        let is_fixed = |(unknown, _): &(S::Unknown, f64)| !problem.free().contains(unknown);
        let fixed: Vec<(S::Unknown, f64)> = first.iter().copied().filter(is_fixed).collect();
        let mut by_fixed = Linearised::of(problem, model, &fixed).columns.into_iter();
        for (j, unknown) in first.iter().enumerate() {
            for (i, row) in alone.columns.iter().enumerate() {
                slopes[(i, j)] = dot(row, &alone.columns[j]);
            }
            let Some(column) = is_fixed(unknown).then(|| by_fixed.next()).flatten() else { continue };
            for (i, row) in later.columns.iter().enumerate() {
                slopes[(before + i, j)] = dot(row, &column);
            }
        }
    }
    for score in scores {
        meat += &score * score.transpose();
    }
    let informations: Vec<DMatrix<f64>> = blocks(problem)
        .into_iter()
        .map(|block| {
            let later = |k: usize| k.checked_sub(before).map(|k| &later.columns[k][block.clone()]);
            DMatrix::from_fn(all, all, |i, j| later(i).zip(later(j)).map_or(0.0, |(a, b)| dot(a, b)))
        })
        .collect();
    for (k, (unknown, step)) in free.iter().enumerate() {
        let Some(sd) = system.prior_sd(*unknown) else { continue };
        let (at, weight) = (before + k, (problem.prior_weight() * step / sd).powi(2));
        slopes[(at, at)] += weight;
        meat[(at, at)] += weight * problem.prior_weight().powi(2);
    }
    let deviations = deviations(&slopes, &meat);
    let effective = EffectiveBlocks::of(&slopes, &informations);
    // Effects of the contact change an unknown in both problems.
    let change = |unknown: S::Unknown, value: f64| {
        let earlier = earlier.filter(|one| one.problem.free().contains(&unknown));
        earlier.map_or(0.0, |one| (S::value(unknown, &one.problem.model()) - value).abs())
    };
    let bounded = |(k, (unknown, step)): (usize, (S::Unknown, f64))| {
        let freedom =
            earlier.filter(|_| k < before).map_or(effective.share(k) * freedom(problem), |one| freedom(&one.problem));
        let value = S::value(unknown, model);
        let half = student(freedom) * deviations[k] * step + change(unknown, value);
        let low = if system.is_positive(unknown) { (value - half).max(0.0) } else { value - half };
        (unknown, Bounded { value, low, high: value + half })
    };
    let is_reported =
        |(k, (unknown, _)): &(usize, (S::Unknown, f64))| *k >= before || !problem.free().contains(unknown);
    first.into_iter().chain(free).enumerate().filter(is_reported).map(bounded).collect()
}

/// Standard deviations in steps; infinite for unknowns without influence, and for all if the problem is singular.
fn deviations(slopes: &DMatrix<f64>, meat: &DMatrix<f64>) -> Vec<f64> {
    let mut deviations = vec![f64::INFINITY; slopes.nrows()];
    let known: Vec<usize> = (0..slopes.nrows()).filter(|k| slopes[(*k, *k)] > 0.0).collect();
    let scale = DVector::from_fn(known.len(), |k, _| 1.0 / slopes[(known[k], known[k])].sqrt().max(1e-150));
    let of_known = |matrix: &DMatrix<f64>| {
        DMatrix::from_fn(known.len(), known.len(), |i, j| matrix[(known[i], known[j])] * scale[i] * scale[j])
    };
    let Some(inverse) = of_known(slopes).try_inverse() else { return deviations };
    let covariance = &inverse * of_known(meat) * inverse.transpose();
    for (k, unknown) in known.iter().enumerate() {
        let deviation = scale[k] * covariance[(k, k)].max(0.0).sqrt();
        deviations[*unknown] = if deviation.is_finite() { deviation } else { f64::INFINITY };
    }
    deviations
}

struct EffectiveBlocks {
    shares: Vec<f64>,
}

impl EffectiveBlocks {
    /// `1 / (B Σ w_b²)` with the shares `w_b` of the B blocks in the variance of an unknown: 1 if all blocks determine
    /// it alike (Bell and McCaffrey 2002, with independent errors of equal size).
    fn of(slopes: &DMatrix<f64>, informations: &[DMatrix<f64>]) -> Self {
        let count = slopes.nrows();
        let scale = DVector::from_fn(count, |k, _| 1.0 / slopes[(k, k)].sqrt().max(1e-150));
        let scaled =
            |matrix: &DMatrix<f64>| DMatrix::from_fn(count, count, |i, j| matrix[(i, j)] * scale[i] * scale[j]);
        let Some(inverse) = scaled(slopes).try_inverse() else { return Self { shares: vec![1.0; count] } };
        let parts: Vec<DVector<f64>> =
            informations.iter().map(|one| (&inverse * scaled(one) * inverse.transpose()).diagonal()).collect();
        let share = |k: usize| {
            let (sum, squares) =
                parts.iter().fold((0.0, 0.0), |(sum, squares), part| (sum + part[k], squares + part[k] * part[k]));
            let share = sum * sum / (squares * parts.len() as f64);
            if share.is_finite() { share } else { 1.0 }
        };
        Self { shares: (0..count).map(share).collect() }
    }

    fn share(&self, unknown: usize) -> f64 {
        self.shares[unknown]
    }
}

fn blocks<S: System>(problem: &Problem<S>) -> Vec<Range<usize>> {
    let mut start = 0;
    let mut blocks = vec![];
    for length in problem.system().lengths() {
        let at = |block: usize| start + block * length / BLOCKS;
        blocks.extend((0..BLOCKS).map(|block| at(block)..at(block + 1)));
        start += length;
    }
    blocks
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn students_quantile_agrees_with_its_table() {
        for (freedom, tabulated, tolerance) in
            [(4.0, 2.776, 0.02), (5.0, 2.571, 0.01), (10.0, 2.228, 0.01), (20.0, 2.086, 0.01), (60.0, 2.000, 0.01)]
        {
            assert!((student(freedom) / tabulated - 1.0).abs() < tolerance, "{freedom}");
        }
    }

    #[test]
    fn a_parameter_without_influence_has_an_infinite_interval() {
        let curvature = DMatrix::from_row_slice(2, 2, &[4.0, 0.0, 0.0, 0.0]);
        let deviations = deviations(&curvature, &DMatrix::identity(2, 2));
        assert_eq!(deviations, [0.25, f64::INFINITY]);
    }
}
