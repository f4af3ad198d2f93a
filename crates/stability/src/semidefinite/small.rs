use nalgebra::DMatrix;

pub(in super::super) fn times(a: &DMatrix<f64>, b: &DMatrix<f64>) -> DMatrix<f64> {
    combined(a, b.ncols(), |k, j| b[(k, j)])
}

pub(super) fn times_transposed(a: &DMatrix<f64>, b: &DMatrix<f64>) -> DMatrix<f64> {
    combined(a, b.nrows(), |k, j| b[(j, k)])
}

/// Column `j` is the sum over `k` of column `k` of `a` times `factor(k, j)`.
#[allow(clippy::needless_range_loop, reason = "adapters of iterators are calls if they are compiled in another unit")]
fn combined(a: &DMatrix<f64>, count: usize, factor: impl Fn(usize, usize) -> f64) -> DMatrix<f64> {
    let (rows, inner) = a.shape();
    let mut product = DMatrix::zeros(rows, count);
    if rows == 0 {
        return product;
    }
    let columns = a.as_slice();
    for (j, to) in product.as_mut_slice().chunks_exact_mut(rows).enumerate() {
        for k in 0..inner {
            let factor = factor(k, j);
            let column = &columns[k * rows..(k + 1) * rows];
            for i in 0..rows {
                to[i] += column[i] * factor;
            }
        }
    }
    product
}

pub(super) fn transposed_times(a: &DMatrix<f64>, b: &DMatrix<f64>) -> DMatrix<f64> {
    times(&a.transpose(), b)
}
