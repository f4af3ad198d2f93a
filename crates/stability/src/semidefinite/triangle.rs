use nalgebra::DMatrix;

/// `i <= j`, column by column.
pub(in super::super) fn row(i: usize, j: usize) -> usize {
    j * (j + 1) / 2 + i
}

pub(super) fn entries(size: usize) -> usize {
    size * (size + 1) / 2
}

pub(super) fn symmetric(matrix: &DMatrix<f64>) -> DMatrix<f64> {
    (matrix + matrix.transpose()) * 0.5
}
