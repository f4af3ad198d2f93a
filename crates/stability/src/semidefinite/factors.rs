//! Cholesky factors of a sparse symmetric matrix.
//!
//! Row `i` of the factor begins at the first nonzero entry of row `i` of the matrix (its envelope; George and Liu,
//! *Computer Solution of Large Sparse Positive Definite Systems*, 1981).

use nalgebra::{DMatrix, DVector};

/// `H = L Lᵀ`, by rows within the envelope.
pub(super) struct Factors {
    /// Its columns are the contiguous rows of the lower triangle.
    upper: DMatrix<f64>,
    first: Vec<usize>,
    rows: Vec<Vec<f64>>,
}

#[allow(clippy::needless_range_loop, reason = "adapters of iterators are calls if they are compiled in another unit")]
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let b = &b[..a.len()];
    let mut sums = [0.0; 4];
    let (a, rest) = a.as_chunks::<4>();
    let (b, other_rest) = b.as_chunks::<4>();
    for i in 0..a.len() {
        for k in 0..4 {
            sums[k] += a[i][k] * b[i][k];
        }
    }
    for k in 0..rest.len() {
        sums[0] += rest[k] * other_rest[k];
    }
    (sums[0] + sums[1]) + (sums[2] + sums[3])
}

const TILE: usize = 32;

/// By tiles, because the transpose is read across columns.
pub(super) fn add_transpose_to_upper(matrix: &mut DMatrix<f64>) {
    let n = matrix.nrows();
    for first_column in (0..n).step_by(TILE) {
        for first_row in (0..=first_column).step_by(TILE) {
            for j in first_column..(first_column + TILE).min(n) {
                for i in first_row..(first_row + TILE).min(j + 1) {
                    matrix[(i, j)] += matrix[(j, i)];
                }
            }
        }
    }
}

impl Factors {
    /// `None` if not positive definite.
    pub(super) fn new(upper: DMatrix<f64>, increase: f64) -> Option<Self> {
        let n = upper.nrows();
        let row = |i: usize| &upper.as_slice()[i * n..i * n + i + 1];
        let first: Vec<usize> = (0..n).map(|i| row(i).iter().position(|value| *value != 0.0).unwrap_or(i)).collect();
        let mut rows: Vec<Vec<f64>> = Vec::with_capacity(n);
        for i in 0..n {
            let begin = first[i];
            let mut now = row(i)[begin..].to_vec();
            now[i - begin] += increase * now[i - begin];
            for j in begin..i {
                let from = begin.max(first[j]);
                let (a, b) = (&now[from - begin..j - begin], &rows[j][from - first[j]..j - first[j]]);
                now[j - begin] = (now[j - begin] - dot(a, b)) / rows[j][j - first[j]];
            }
            let square = now[i - begin] - dot(&now[..i - begin], &now[..i - begin]);
            if !(square > 0.0 && square.is_finite()) {
                return None;
            }
            now[i - begin] = square.sqrt();
            rows.push(now);
        }
        Some(Self { upper, first, rows })
    }

    pub(super) fn product(&self, x: &DVector<f64>) -> DVector<f64> {
        let (n, values) = (self.rows.len(), x.as_slice());
        let mut product = DVector::zeros(n);
        let sums = product.as_mut_slice();
        for i in 0..n {
            let begin = self.first[i];
            let row = &self.upper.as_slice()[i * n + begin..i * n + i];
            sums[i] += self.upper[(i, i)] * values[i] + dot(row, &values[begin..i]);
            let to = &mut sums[begin..i];
            for k in 0..to.len() {
                to[k] += row[k] * values[i];
            }
        }
        product
    }

    pub(super) fn solve(&self, b: &DVector<f64>) -> DVector<f64> {
        let n = self.rows.len();
        let mut x = b.clone();
        let values = x.as_mut_slice();
        for i in 0..n {
            let (begin, row) = (self.first[i], &self.rows[i]);
            values[i] = (values[i] - dot(&row[..i - begin], &values[begin..i])) / row[i - begin];
        }
        for i in (0..n).rev() {
            let (begin, row) = (self.first[i], &self.rows[i]);
            let value = values[i] / row[i - begin];
            values[i] = value;
            let to = &mut values[begin..i];
            for k in 0..to.len() {
                to[k] -= row[k] * value;
            }
        }
        x
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_banded_matrix_with_a_full_row_is_factored_within_its_envelope() {
        let n = 23;
        let h = DMatrix::from_fn(n, n, |i: usize, j: usize| match (i == n - 1 || j == n - 1, i.abs_diff(j)) {
            (_, 0) => 6.0,
            (true, _) => 0.1,
            (_, 1..=2) => -1.0,
            _ => 0.0,
        });
        let mut half = DMatrix::from_fn(n, n, |i, j| {
            h[(i, j)]
                * if i == j {
                    0.5
                } else if i < j {
                    0.25
                } else {
                    0.75
                }
        });
        add_transpose_to_upper(&mut half);
        assert!((half.upper_triangle() - h.upper_triangle()).norm() < 1e-15);
        let factors = Factors::new(h.clone(), 0.0).expect("positive definite");
        assert!(factors.rows[10].len() == 3 && factors.rows[n - 1].len() == n);
        let b = DVector::from_fn(n, |k, _| (k as f64).sin());
        assert!((&h * &b - factors.product(&b)).norm() < 1e-13);
        assert!((&h * factors.solve(&b) - &b).norm() < 1e-13);
        assert!(Factors::new(-h, 0.0).is_none());
    }
}
