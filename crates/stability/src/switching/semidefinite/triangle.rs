//! Symmetric matrices by their upper triangle.

use nalgebra::DMatrix;

/// Place of entry `(i, j)`, `i <= j`, in a triangle: column by column.
pub(in super::super) fn row(i: usize, j: usize) -> usize {
    j * (j + 1) / 2 + i
}

/// Number of entries of the triangle of a matrix of a size.
pub(super) fn entries(size: usize) -> usize {
    size * (size + 1) / 2
}

/// `(M + Mᵀ) / 2`.
pub(super) fn symmetric(matrix: &DMatrix<f64>) -> DMatrix<f64> {
    (matrix + matrix.transpose()) * 0.5
}
