//! Linear matrix inequalities, and their solution.

use nalgebra::{DMatrix, DVector};
use std::f64::consts::SQRT_2;

use super::semidefinite::{self, Block, Programme, Status, entries, row};
use crate::stability::StabilityError;

/// `c Mᵀ X M` for one of the unknown symmetric matrices `X`.
#[derive(Debug, Clone)]
pub(super) struct Term {
    pub(super) factor: f64,
    pub(super) unknown: usize,
    pub(super) map: DMatrix<f64>,
}

/// A sum of terms that must be positive definite.
#[derive(Debug, Clone)]
pub(super) struct Condition {
    pub(super) terms: Vec<Term>,
    /// The weight of the margin: a condition per tick has less margin than one per event.
    pub(super) weight: f64,
    /// A row whose square, times the margin, is a lower bound.
    pub(super) row: Option<DMatrix<f64>>,
    /// A fixed lower bound.
    pub(super) offset: f64,
}

/// The normalisation of the matrices.
#[derive(Debug, Clone)]
pub(super) enum Normal {
    /// Their traces are 1 on average over their rows.
    Traces,
    /// The mean of `xᵀ X x` of one of them over these states is 1.
    Level(usize, Vec<DVector<f64>>),
}

/// Maximum mean of the diagonals if the level is fixed.
const MAX_MEAN_DIAGONAL: f64 = 1e4;

/// The accuracy at which the margin of a programme without a level counts as found.
const MIN_ACCURACY: f64 = 1e-4;

/// The matrices of the given sizes that satisfy the conditions with the maximum common margin, and that margin: the
/// conditions are feasible if it is above 0.
///
/// # Errors
/// [`StabilityError::Solver`] if the solver fails.
pub(super) fn solve(
    sizes: &[usize],
    conditions: &[Condition],
    normal: &Normal,
) -> Result<(Vec<DMatrix<f64>>, f64), StabilityError> {
    let variables = Variables::new(sizes);
    let mut objective = DVector::zeros(variables.margin + 1);
    objective[variables.margin] = 1.0;
    let mut blocks: Vec<Block> = conditions.iter().map(|condition| variables.block(condition)).collect();
    let traces = variables.traces();
    let equation = match normal {
        Normal::Traces => (traces, sizes.iter().sum::<usize>() as f64),
        Normal::Level(unknown, states) => {
            // Bounds the directions that no motion from these states reaches.
            blocks.push(Block {
                size: 1,
                variables: (0..variables.margin).collect(),
                map: DMatrix::from_fn(1, variables.margin, |_, k| -traces[k]),
                constant: DVector::from_element(1, MAX_MEAN_DIAGONAL * sizes.iter().sum::<usize>() as f64),
            });
            (variables.level(*unknown, states), states.len() as f64)
        }
    };
    let solution = semidefinite::solve(&Programme { objective, equation, blocks });
    let is_found = match (solution.status, normal) {
        (Status::Solved, _) => true,
        (Status::Stalled, Normal::Traces) => solution.accuracy < MIN_ACCURACY,
        // Tight bounds reach the limit of the arithmetic; the result is verified in any case.
        (Status::Stalled, Normal::Level(..)) => solution.accuracy.is_finite(),
        (Status::Infeasible, _) => false,
    };
    if !is_found {
        return Err(StabilityError::Solver { status: format!("{:?}", solution.status) });
    }
    Ok((variables.matrices(&solution.y), solution.y[variables.margin]))
}

/// The variables of a programme: the triangles of the unknown matrices, one after the other, then the margin.
struct Variables<'a> {
    sizes: &'a [usize],
    /// The first variable of each matrix.
    starts: Vec<usize>,
    margin: usize,
}

impl<'a> Variables<'a> {
    fn new(sizes: &'a [usize]) -> Self {
        let (mut starts, mut margin) = (vec![], 0);
        for &size in sizes {
            starts.push(margin);
            margin += entries(size);
        }
        Self { sizes, starts, margin }
    }

    /// The sum of all traces, as a row over the variables.
    fn traces(&self) -> DVector<f64> {
        let mut sum = DVector::zeros(self.margin + 1);
        for (&size, &start) in self.sizes.iter().zip(&self.starts) {
            for k in 0..size {
                sum[start + row(k, k)] = 1.0;
            }
        }
        sum
    }

    /// The sum of `xᵀ X x` over states, as a row over the variables.
    fn level(&self, unknown: usize, states: &[DVector<f64>]) -> DVector<f64> {
        let mut sum = DVector::zeros(self.margin + 1);
        for j in 0..self.sizes[unknown] {
            for i in 0..=j {
                let once: f64 = states.iter().map(|state| state[i] * state[j]).sum();
                sum[self.starts[unknown] + row(i, j)] = if i == j { once } else { 2.0 * once };
            }
        }
        sum
    }

    fn matrices(&self, y: &DVector<f64>) -> Vec<DMatrix<f64>> {
        let matrix =
            |(&size, &start): (&usize, &usize)| DMatrix::from_fn(size, size, |i, j| y[start + row(i.min(j), i.max(j))]);
        self.sizes.iter().zip(&self.starts).map(matrix).collect()
    }

    /// A condition as a block that must be positive semidefinite.
    fn block(&self, condition: &Condition) -> Block {
        let size = condition.terms[0].map.ncols();
        let mut unknowns: Vec<usize> = condition.terms.iter().map(|term| term.unknown).collect();
        unknowns.sort_unstable();
        unknowns.dedup();
        let mut variables = vec![];
        for &unknown in &unknowns {
            variables.extend((0..entries(self.sizes[unknown])).map(|k| self.starts[unknown] + k));
        }
        variables.push(self.margin);
        let mut map = DMatrix::zeros(entries(size), variables.len());
        let mut constant = DVector::zeros(entries(size));
        let mut start = 0;
        for &unknown in &unknowns {
            for term in condition.terms.iter().filter(|term| term.unknown == unknown) {
                add(&mut map, start, term);
            }
            start += entries(self.sizes[unknown]);
        }
        for j in 0..size {
            constant[row(j, j)] = -condition.offset;
            for i in 0..=j {
                let of_row = condition.row.as_ref().map_or(0.0, |row| row[i] * row[j]);
                map[(row(i, j), start)] = if i == j { -of_row - condition.weight } else { -SQRT_2 * of_row };
            }
        }
        Block { size, variables, map, constant }
    }
}

/// Adds a term to the columns of its unknown, which begin at `start`.
fn add(map: &mut DMatrix<f64>, start: usize, term: &Term) {
    let m = &term.map;
    for q in 0..m.nrows() {
        for p in 0..=q {
            let mut column = map.column_mut(start + row(p, q));
            for j in 0..m.ncols() {
                for i in 0..=j {
                    let twice = m[(p, i)] * m[(q, j)] + m[(q, i)] * m[(p, j)];
                    let once = term.factor * if p == q { 0.5 * twice } else { twice };
                    column[row(i, j)] += if i == j { once } else { SQRT_2 * once };
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn term(factor: f64, map: &DMatrix<f64>) -> Term {
        Term { factor, unknown: 0, map: map.clone() }
    }

    /// Conditions of `Aᵀ X A < X` and of a positive `X`, for each of the matrices.
    fn common(matrices: &[DMatrix<f64>]) -> Vec<Condition> {
        let one = DMatrix::identity(2, 2);
        let exceeding = |terms| Condition { terms, weight: 1.0, row: None, offset: 0.0 };
        let positive = exceeding(vec![term(1.0, &one)]);
        let decreasing = matrices.iter().map(|a| exceeding(vec![term(1.0, &one), term(-1.0, a)]));
        decreasing.chain([positive]).collect()
    }

    #[test]
    fn the_margin_of_a_contraction_is_what_it_leaves() {
        // X = I is the best for A = a I: the margin is 1 - a².
        for a in [0.0, 0.5, 0.99] {
            let (found, margin) =
                solve(&[2], &common(&[DMatrix::identity(2, 2) * a]), &Normal::Traces).expect("solved");
            assert!((margin - (1.0 - a * a)).abs() < 1e-7 && (&found[0] - DMatrix::identity(2, 2)).norm() < 1e-3);
        }
    }

    #[test]
    fn a_level_is_kept_and_an_infeasible_level_is_refused() {
        // Within the level 1 at (1, 0), the row (1, 0) comes to 1: X - t rᵀr with the minimum t = 1 on both sides.
        let one = DMatrix::identity(2, 2);
        let row = DMatrix::from_row_slice(1, 2, &[1.0, 0.0]);
        let bounded = Condition { terms: vec![term(1.0, &one)], weight: 0.0, row: Some(row), offset: 0.0 };
        let level = Normal::Level(0, vec![DVector::from_column_slice(&[1.0, 0.0])]);
        let (found, margin) = solve(&[2], std::slice::from_ref(&bounded), &level).expect("solved");
        assert!((margin - 1.0).abs() < 1e-6 && (found[0][(0, 0)] - 1.0).abs() < 1e-6);
        let growing = DMatrix::identity(2, 2) * 1.1;
        let terms = vec![term(1.0, &one), term(-1.0, &growing)];
        let decreasing = Condition { terms, weight: 0.0, row: None, offset: 1e-3 };
        assert!(solve(&[2], &[bounded, decreasing], &level).is_err());
    }

    #[test]
    fn two_stable_matrices_have_a_common_function_only_if_it_exists() {
        let turn = |angle: f64, stretch: f64| {
            let (s, c) = angle.sin_cos();
            DMatrix::from_row_slice(2, 2, &[c, -s * stretch, s / stretch, c]) * 0.8
        };
        let pair = |stretch: f64| [turn(1.0, stretch), turn(1.0, 1.0 / stretch)];
        let (found, margin) = solve(&[2], &common(&pair(1.1)), &Normal::Traces).expect("solved");
        assert!(margin > 0.0);
        for a in pair(1.1) {
            let less = &found[0] - a.transpose() * &found[0] * a;
            assert!(less.symmetric_eigenvalues().min() >= 0.99 * margin);
        }
        // Their product has an eigenvalue outside the unit circle: no function decreases along both.
        let [a, b] = pair(4.0);
        assert!((a * b).complex_eigenvalues().iter().any(|value| value.norm() > 1.0));
        assert!(solve(&[2], &common(&pair(4.0)), &Normal::Traces).expect("solved").1 <= 1e-9);
    }
}
