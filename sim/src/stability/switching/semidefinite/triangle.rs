//! Symmetric matrices packed into vectors.

use nalgebra::{DMatrix, DVector};
use std::f64::consts::SQRT_2;

/// Row of entry `(i, j)`, `i <= j`, in a packed matrix: the upper triangle, column by column.
pub(in super::super) fn row(i: usize, j: usize) -> usize {
    j * (j + 1) / 2 + i
}

/// Number of entries of the triangle of a matrix of a size.
pub(in super::super) fn entries(size: usize) -> usize {
    size * (size + 1) / 2
}

/// A symmetric matrix as a vector with the same inner product: entries off the diagonal times √2.
pub(super) fn pack(matrix: &DMatrix<f64>) -> DVector<f64> {
    let mut packed = DVector::zeros(entries(matrix.nrows()));
    for j in 0..matrix.nrows() {
        for i in 0..j {
            packed[row(i, j)] = SQRT_2 * matrix[(i, j)];
        }
        packed[row(j, j)] = matrix[(j, j)];
    }
    packed
}

/// The inverse of [`pack`].
pub(super) fn unpack(packed: &DVector<f64>, size: usize) -> DMatrix<f64> {
    let entry = |i: usize, j: usize| {
        let value = packed[row(i.min(j), i.max(j))];
        if i == j { value } else { value / SQRT_2 }
    };
    DMatrix::from_fn(size, size, entry)
}

/// `(M + Mᵀ) / 2`.
pub(super) fn symmetric(matrix: &DMatrix<f64>) -> DMatrix<f64> {
    (matrix + matrix.transpose()) * 0.5
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn packing_keeps_the_matrix_and_the_inner_product() {
        let [a, b] = [1.0, 2.0].map(|k| symmetric(&DMatrix::from_fn(4, 4, |i, j| (k * (3 * i + 5 * j) as f64).sin())));
        assert!((unpack(&pack(&a), 4) - &a).norm() < 1e-15);
        assert!((pack(&a).dot(&pack(&b)) - (&a * &b).trace()).abs() < 1e-14);
    }
}
