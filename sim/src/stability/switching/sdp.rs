//! Linear matrix inequalities, and the search for matrices that fulfil them.

use clarabel::algebra::CscMatrix;
use clarabel::solver::{DefaultSettings, DefaultSolver, IPSolver, SolverStatus, SupportedConeT};
use nalgebra::{DMatrix, DVector};

use crate::stability::StabilityError;

/// `c Mᵀ X M` for one of the unknown symmetric matrices `X`.
#[derive(Debug, Clone)]
pub(super) struct Term {
    pub(super) factor: f64,
    pub(super) unknown: usize,
    pub(super) map: DMatrix<f64>,
}

/// A sum of terms that is to be positive definite.
#[derive(Debug, Clone)]
pub(super) struct Condition {
    pub(super) terms: Vec<Term>,
    /// What it is to exceed the margin times, a condition that holds from tick to tick having less to give than one that
    /// holds over an event.
    pub(super) weight: f64,
    /// A row whose square is to be exceeded the margin times.
    pub(super) row: Option<DMatrix<f64>>,
    /// What is to be exceeded in any case.
    pub(super) least: f64,
}

/// What keeps the matrices from growing for ever.
#[derive(Debug, Clone)]
pub(super) enum Normal {
    /// Their traces are 1 on average over their rows.
    Traces,
    /// One of them has the mean 1 over these states.
    Level(usize, Vec<DVector<f64>>),
}

/// The greatest mean of the diagonals where the level is what is fixed.
const LARGEST: f64 = 1e4;

/// Row of entry `(i, j)`, `i <= j`, in the solver's triangle, column by column.
fn row(i: usize, j: usize) -> usize {
    j * (j + 1) / 2 + i
}

/// The matrices of the given sizes that exceed the conditions by the greatest common margin, and that margin: the conditions
/// can be met where it is above 0.
///
/// # Errors
/// [`StabilityError::Solver`] where the solver gives up.
pub(super) fn solve(
    sizes: &[usize],
    conditions: &[Condition],
    normal: &Normal,
) -> Result<(Vec<DMatrix<f64>>, f64), StabilityError> {
    let starts: Vec<usize> = sizes
        .iter()
        .scan(0, |next, &size| {
            let start = *next;
            *next += size * (size + 1) / 2;
            Some(start)
        })
        .collect();
    let margin = sizes.iter().map(|size| size * (size + 1) / 2).sum::<usize>();
    let mut columns: Vec<Vec<(usize, f64)>> = vec![vec![]; margin + 1];
    let mut cones = vec![SupportedConeT::ZeroConeT(1)];
    let one = match normal {
        Normal::Traces => {
            for (&size, &start) in sizes.iter().zip(&starts) {
                for k in 0..size {
                    columns[start + row(k, k)].push((0, 1.0));
                }
            }
            sizes.iter().sum::<usize>() as f64
        }
        Normal::Level(unknown, states) => {
            for j in 0..sizes[*unknown] {
                for i in 0..=j {
                    let twice: f64 = states.iter().map(|state| 2.0 * state[i] * state[j]).sum();
                    columns[starts[*unknown] + row(i, j)].push((0, if i == j { 0.5 * twice } else { twice }));
                }
            }
            states.len() as f64
        }
    };
    let mut b = vec![one];
    if let Normal::Level(..) = normal {
        // What no motion from there meets is not to grow for ever.
        b.push(LARGEST * sizes.iter().sum::<usize>() as f64);
        cones.push(SupportedConeT::NonnegativeConeT(1));
        for (&size, &start) in sizes.iter().zip(&starts) {
            for k in 0..size {
                columns[start + row(k, k)].push((1, 1.0));
            }
        }
    }
    for condition in conditions {
        let size = condition.terms[0].map.ncols();
        let at = b.len();
        let rows = size * (size + 1) / 2;
        b.resize(at + rows, 0.0);
        cones.push(SupportedConeT::PSDTriangleConeT(size));
        for j in 0..size {
            b[at + row(j, j)] = -condition.least;
            for i in 0..=j {
                let of_row = condition.row.as_ref().map_or(0.0, |row| row[i] * row[j]);
                let value = if i == j { of_row + condition.weight } else { std::f64::consts::SQRT_2 * of_row };
                if value != 0.0 {
                    columns[margin].push((at + row(i, j), value));
                }
            }
        }
        for (unknown, &start) in starts.iter().enumerate() {
            let terms: Vec<&Term> = condition.terms.iter().filter(|term| term.unknown == unknown).collect();
            if terms.is_empty() {
                continue;
            }
            for q in 0..sizes[unknown] {
                for p in 0..=q {
                    let column = &mut columns[start + row(p, q)];
                    for j in 0..size {
                        for i in 0..=j {
                            let entry = |term: &&Term| {
                                let m = &term.map;
                                let twice = m[(p, i)] * m[(q, j)] + m[(q, i)] * m[(p, j)];
                                term.factor * if p == q { 0.5 * twice } else { twice }
                            };
                            let sum: f64 = terms.iter().map(entry).sum();
                            if sum != 0.0 {
                                let off = if i == j { 1.0 } else { std::f64::consts::SQRT_2 };
                                column.push((at + row(i, j), -off * sum));
                            }
                        }
                    }
                }
            }
        }
    }
    let (rows, n) = (b.len(), margin + 1);
    let mut starts_of_columns = vec![0];
    let (mut indices, mut values) = (vec![], vec![]);
    for column in &columns {
        indices.extend(column.iter().map(|(row, _)| *row));
        values.extend(column.iter().map(|(_, value)| *value));
        starts_of_columns.push(indices.len());
    }
    let a = CscMatrix::new(rows, n, starts_of_columns, indices, values);
    let mut q = vec![0.0; n];
    q[margin] = -1.0;
    let settings =
        DefaultSettings { verbose: false, chordal_decomposition_enable: false, ..DefaultSettings::default() };
    let mut solver = DefaultSolver::new(&CscMatrix::zeros((n, n)), &q, &a, &b, &cones, settings)
        .map_err(|error| StabilityError::Solver { status: error.to_string() })?;
    solver.solve();
    let solution = &solver.solution;
    let is_number = solution.x.iter().all(|value| value.is_finite());
    match solution.status {
        SolverStatus::Solved | SolverStatus::AlmostSolved | SolverStatus::InsufficientProgress if is_number => {}
        // Tight bounds end where numbers do; what was found by then is verified like everything.
        SolverStatus::NumericalError | SolverStatus::MaxIterations
            if is_number && matches!(normal, Normal::Level(..)) => {}
        status => return Err(StabilityError::Solver { status: status.to_string() }),
    }
    let x = &solution.x;
    let matrices = sizes
        .iter()
        .zip(&starts)
        .map(|(&size, &start)| DMatrix::from_fn(size, size, |i, j| x[start + row(i.min(j), i.max(j))]))
        .collect();
    Ok((matrices, x[margin]))
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
        let exceeding = |terms| Condition { terms, weight: 1.0, row: None, least: 0.0 };
        let positive = exceeding(vec![term(1.0, &one)]);
        let decreasing = matrices.iter().map(|a| exceeding(vec![term(1.0, &one), term(-1.0, a)]));
        decreasing.chain([positive]).collect()
    }

    #[test]
    fn two_stable_matrices_have_a_common_function_just_where_they_can() {
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
        // Their product has an eigenvalue beyond the circle: no function can decrease along both.
        let [a, b] = pair(4.0);
        assert!((a * b).complex_eigenvalues().iter().any(|value| value.norm() > 1.0));
        assert!(solve(&[2], &common(&pair(4.0)), &Normal::Traces).expect("solved").1 <= 1e-9);
    }
}
