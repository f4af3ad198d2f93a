//! 95 % intervals from residuals that are correlated in time.

use nalgebra::{DMatrix, DVector};

use crate::actuator::Bounded;
use crate::machine::Machine;
use crate::measured::Measured;
use crate::problem::Problem;
use crate::structure::Parameter;

/// The number of blocks of a recording. Residuals are correlated within a block, and blocks count as independent.
pub(crate) const BLOCKS: usize = 12;

/// Step of the derivatives by a value, relative to the value or to its start.
const STEP: f64 = 1e-3;

/// Returns the 97.5 % quantile of Student's t, within 1 % for at least 5 degrees of freedom (two terms of its expansion
/// in 1/n).
pub(crate) fn student(freedom: f64) -> f64 {
    let n = freedom.max(5.0);
    let z: f64 = 1.959_964;
    z + (z.powi(3) + z) / (4.0 * n) + (5.0 * z.powi(5) + 16.0 * z.powi(3) + 3.0 * z) / (96.0 * n * n)
}

/// Returns the interval of each free parameter of a solved problem with its machine, in order. A parameter that the recordings do not
/// determine has an infinite interval.
///
/// The covariance is the sandwich `H⁻¹ M H⁻¹`. H is the curvature `JᵀJ`, M the sum over blocks of the outer products of
/// the block's gradient `Σ J_i r_i`. The priors of the sensor count as further observations.
pub(crate) fn intervals(problem: &Problem<'_>, machine: &Machine, start: &Machine) -> Vec<Bounded> {
    let free = problem.free();
    let here = problem.errors(machine);
    let steps: Vec<f64> = free.iter().map(|one| STEP * one.of(machine).abs().max(0.1 * one.of(start).abs())).collect();
    let columns: Vec<Vec<f64>> = free
        .iter()
        .zip(&steps)
        .map(|(parameter, step)| {
            let mut moved = *machine;
            parameter.set(&mut moved, parameter.of(machine) + step);
            // Derivatives by steps, so that all columns have similar magnitudes.
            problem.errors(&moved).iter().zip(&here).map(|(moved, here)| moved - here).collect()
        })
        .collect();
    let count = free.len();
    let mut curvature = DMatrix::from_fn(count, count, |i, j| dot(&columns[i], &columns[j]));
    let mut meat = DMatrix::zeros(count, count);
    for block in blocks(problem.recordings()) {
        let score = DVector::from_iterator(
            count,
            columns.iter().map(|column| dot(&column[block.clone()], &here[block.clone()])),
        );
        meat += &score * score.transpose();
    }
    let number = (BLOCKS * problem.recordings().len()) as f64;
    let freedom = number - count as f64;
    meat *= number / freedom.max(1.0);
    for (k, parameter) in free.iter().enumerate() {
        let Some((_, sd)) = problem.prior(*parameter) else { continue };
        let weight = (problem.prior_weight() * steps[k] / sd).powi(2);
        curvature[(k, k)] += weight;
        meat[(k, k)] += weight * problem.prior_weight().powi(2);
    }
    let half = half_widths(&curvature, &meat, student(freedom));
    let bounded = |(k, parameter): (usize, &Parameter)| {
        let (value, half) = (parameter.of(machine), half[k] * steps[k]);
        let low = if parameter.is_positive() { (value - half).max(0.0) } else { value - half };
        Bounded { value, low, high: value + half }
    };
    free.iter().enumerate().map(bounded).collect()
}

fn half_widths(curvature: &DMatrix<f64>, meat: &DMatrix<f64>, quantile: f64) -> Vec<f64> {
    let count = curvature.nrows();
    let scale = DVector::from_fn(count, |k, _| 1.0 / curvature[(k, k)].sqrt().max(1e-150));
    let scaled = DMatrix::from_fn(count, count, |i, j| curvature[(i, j)] * scale[i] * scale[j]);
    let Some(cholesky) = scaled.cholesky() else { return vec![f64::INFINITY; count] };
    let inverse = cholesky.inverse();
    let inverse = DMatrix::from_fn(count, count, |i, j| inverse[(i, j)] * scale[i] * scale[j]);
    let covariance = &inverse * meat * &inverse;
    let half = |k: usize| {
        let half = quantile * covariance[(k, k)].max(0.0).sqrt();
        // No sensitivity at all: the parameter is unknown.
        if half.is_finite() && curvature[(k, k)] > 0.0 { half } else { f64::INFINITY }
    };
    (0..count).map(half).collect()
}

/// Returns the ranges of the blocks among the errors of all recordings.
fn blocks(recordings: &[Measured]) -> Vec<std::ops::Range<usize>> {
    let mut start = 0;
    let mut blocks = vec![];
    for one in recordings {
        let at = |block: usize| start + block * one.len() / BLOCKS;
        blocks.extend((0..BLOCKS).map(|block| at(block)..at(block + 1)));
        start += one.len();
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
        for (freedom, tabulated) in [(5.0, 2.571), (10.0, 2.228), (20.0, 2.086), (60.0, 2.000)] {
            assert!((student(freedom) / tabulated - 1.0).abs() < 0.01, "{freedom}");
        }
    }

    #[test]
    fn a_parameter_without_influence_has_an_infinite_interval() {
        let curvature = DMatrix::from_row_slice(2, 2, &[4.0, 0.0, 0.0, 0.0]);
        let half = half_widths(&curvature, &DMatrix::identity(2, 2), 2.0);
        assert_eq!(half[1], f64::INFINITY);
    }
}
