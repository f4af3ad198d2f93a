//! The tightness of the certificate: growth of enumerated sequences of events.
//!
//! A cycle is an event and the teleoperation after it, one matrix for given lengths and stiffness. The joint spectral
//! radius of all cycles lies between the maximum `ρ(M_1 ⋯ M_k)^(1/k)` of the products and the upper bound of
//! Gripenberg's enumeration (*Linear Algebra Appl.* 234, 1996): products are continued while the minimum norm of their
//! prefixes exceeds the best radius by more than a tolerance. Above 1 some sequence grows; it grows in the engine too,
//! because the engine can run each cycle. The bounds apply to the finitely many cycles tried.

use nalgebra::{Cholesky, DMatrix};

use super::modes::Modes;
use super::settings::Phases;
use crate::augmentation::cross_fade;
use crate::lti::eigenvalues;
use crate::stability::StabilityError;

/// Target difference of the upper and the lower bound.
const TOLERANCE: f64 = 0.01;

/// Maximum length of a product.
const MAX_EVENTS: usize = 8;

/// Maximum number of products.
const MAX_PRODUCTS: usize = 20_000;

/// Number of teleoperation lengths that are tried, and their range in ticks above the shortest.
const DWELLS: usize = 10;
const EXTRA_TICKS: u64 = 400;

/// An event with the teleoperation after it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cycle {
    /// Frozen ticks.
    pub held_ticks: u64,
    /// Ticks of teleoperation after it.
    pub dwell_ticks: u64,
    /// The end of the stiffness's range: 0 softest, 1 stiffest.
    pub vertex: usize,
}

/// The result of the enumeration.
#[derive(Debug, Clone, PartialEq)]
pub struct Growth {
    /// Factor per event of the worst product found: a lower bound of the joint spectral radius.
    pub lower: f64,
    /// An upper bound of it, for the cycles tried.
    pub upper: f64,
    /// That product, in order of time.
    pub worst: Vec<Cycle>,
    /// Number of products.
    pub products: usize,
}

/// A product, with the minimum norm of its prefixes.
struct Node {
    matrix: DMatrix<f64>,
    word: Vec<usize>,
    min_norm: f64,
}

fn radius(matrix: &DMatrix<f64>) -> Result<f64, StabilityError> {
    // An unstable loop can exceed the range of doubles.
    if matrix.iter().any(|value| !value.is_finite()) {
        return Ok(f64::INFINITY);
    }
    Ok(eigenvalues(matrix)?.into_iter().map(|value| value.norm()).fold(0.0, f64::max))
}

/// `Aⁿ`.
fn power(a: &DMatrix<f64>, mut n: u64) -> DMatrix<f64> {
    let (mut result, mut base) = (DMatrix::identity(a.nrows(), a.nrows()), a.clone());
    while n > 0 {
        if n % 2 == 1 {
            result = &result * &base;
        }
        n /= 2;
        base = &base * &base;
    }
    result
}

/// A cycle from the last tick before an event to that of the next one, on `(x, g)` if the gap is kept, else on `x`. For
/// motions so small that a ramp closes its gap in the tick after the first and the force of `amplify` is not floored.
pub(super) fn matrix(modes: &Modes, phases: Phases, cycle: Cycle) -> DMatrix<f64> {
    let Cycle { held_ticks, dwell_ticks, vertex } = cycle;
    let n = modes.states();
    let share = *modes.shares().last().unwrap_or(&1.0);
    let frozen = power(&modes.frozen(vertex, share), held_ticks) * modes.entry(vertex);
    // `(x, F_a, g)`.
    let mut state = DMatrix::zeros(n + 2, frozen.ncols());
    state.rows_mut(0, n + 1).copy_from(&(modes.release() * &frozen));
    if modes.has_gap() {
        state.rows_mut(n + 1, 1).copy_from(&(modes.gap() * &frozen));
    }
    for tick in 0..phases.blend {
        let weight = cross_fade((tick + 1) as f64 / phases.blend as f64);
        let next = modes.blend(vertex, weight) * &state;
        state.rows_mut(0, n + 1).copy_from(&next);
        if modes.gap_closes() {
            state.row_mut(n + 1).fill(0.0);
        }
    }
    if modes.gap_closes() {
        return power(&modes.teleoperation(vertex), dwell_ticks - 1) * state.rows(0, n);
    }
    let mut with_gap = DMatrix::identity(n + 1, n + 1);
    with_gap.rows_mut(0, n).copy_from(&modes.apart_by_gap(vertex));
    let mut start = DMatrix::zeros(n + 1, n + 1);
    start.rows_mut(0, n).copy_from(&state.rows(0, n));
    start.row_mut(n).copy_from(&state.row(n + 1));
    power(&with_gap, dwell_ticks - 1) * start
}

/// The tried cycles, on one end of the stiffness's range or on both.
fn cycles(phases: Phases, dwell: u64, vertices: &[usize]) -> Vec<Cycle> {
    let (shortest, longest) = phases.held;
    let mut all = vec![];
    for &vertex in vertices {
        for held_ticks in if shortest == longest { vec![shortest] } else { vec![shortest, longest] } {
            for k in 0..DWELLS as u64 {
                all.push(Cycle {
                    held_ticks,
                    dwell_ticks: dwell + k * k * EXTRA_TICKS / (DWELLS * DWELLS) as u64,
                    vertex,
                });
            }
        }
    }
    all
}

/// Bounds of the growth per event with at least `dwell` ticks of teleoperation between events. `norm` is a positive
/// definite matrix that defines the norm.
///
/// # Errors
/// [`StabilityError::Algebra`].
pub(super) fn growth(
    modes: &Modes,
    phases: Phases,
    dwell: u64,
    vertices: &[usize],
    norm: Option<&DMatrix<f64>>,
) -> Result<Growth, StabilityError> {
    let cycles = cycles(phases, dwell, vertices);
    let matrices: Vec<DMatrix<f64>> = cycles.iter().map(|&cycle| matrix(modes, phases, cycle)).collect();
    let size = matrices[0].nrows();
    let root = norm
        .filter(|p| p.nrows() == size)
        .and_then(|p| Cholesky::new(p.clone()))
        .map_or_else(|| DMatrix::identity(size, size), |found| found.l().transpose());
    let inverse = root.clone().try_inverse().unwrap_or_else(|| DMatrix::identity(size, size));
    let length = |matrix: &DMatrix<f64>| {
        let scaled = &root * matrix * &inverse;
        let square = scaled.transpose() * scaled;
        if square.iter().all(|value| value.is_finite()) {
            square.symmetric_eigenvalues().max().max(0.0).sqrt()
        } else {
            f64::INFINITY
        }
    };
    let mut found = Growth { lower: 0.0, upper: 0.0, worst: vec![], products: 0 };
    let mut open = vec![Node { matrix: DMatrix::identity(size, size), word: vec![], min_norm: f64::INFINITY }];
    let mut left: f64 = 0.0;
    for events in 1..=MAX_EVENTS {
        let mut next = vec![];
        left = 0.0;
        for node in &open {
            for (k, one) in matrices.iter().enumerate() {
                found.products += 1;
                let matrix = one * &node.matrix;
                let root = |value: f64| value.powf(1.0 / events as f64);
                let (radius, min_norm) = (root(radius(&matrix)?), root(length(&matrix)).min(node.min_norm));
                let word: Vec<usize> = node.word.iter().copied().chain([k]).collect();
                // Prefers the shortest of equal products.
                if radius > found.lower * (1.0 + 1e-9) {
                    found.lower = radius;
                    found.worst = word.iter().map(|&k| cycles[k]).collect();
                }
                left = left.max(min_norm);
                next.push(Node { matrix, word, min_norm });
            }
        }
        next.retain(|node| node.min_norm > found.lower + TOLERANCE && found.lower.is_finite());
        if next.is_empty() || (found.products + next.len() * matrices.len()) > MAX_PRODUCTS {
            left = next.iter().map(|node| node.min_norm).fold(0.0, f64::max);
            break;
        }
        open = next;
    }
    found.upper = left.max(found.lower + TOLERANCE);
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_power_is_a_product() {
        let a = DMatrix::from_row_slice(2, 2, &[0.9, 0.3, -0.2, 0.95]);
        let expected = (0..13).fold(DMatrix::identity(2, 2), |all, _| all * &a);
        assert!((power(&a, 13) - expected).norm() < 1e-14);
        assert_eq!(power(&a, 0), DMatrix::identity(2, 2));
    }
}
