use nalgebra::{DMatrix, DVector};

/// Minimum explained share of the targets' variance for a start.
const LEAST_SHARE: f64 = 0.2;

/// `squares` of the residuals; `spread` of the targets around their mean.
pub(super) struct Regression {
    pub(super) coefficients: Vec<f64>,
    pub(super) squares: f64,
    spread: f64,
}

impl Regression {
    pub(super) fn explains_enough(&self) -> bool {
        self.squares <= (1.0 - LEAST_SHARE) * self.spread
    }
}

/// `None` without a unique solution.
pub(super) fn regression(rows: &[(Vec<f64>, f64)]) -> Option<Regression> {
    let count = rows.first()?.0.len();
    let mut normal = DMatrix::zeros(count, count);
    let mut right = DVector::zeros(count);
    for (row, target) in rows {
        let row = DVector::from_column_slice(row);
        right += &row * *target;
        normal.ger(1.0, &row, &row, 1.0);
    }
    let scale = DVector::from_fn(count, |k, _| 1.0 / f64::max(normal[(k, k)], 1e-300).sqrt());
    let scaled = DMatrix::from_fn(count, count, |i, j| normal[(i, j)] * scale[i] * scale[j]);
    let solved = scaled.cholesky()?.solve(&right.component_mul(&scale));
    let coefficients: Vec<f64> = solved.component_mul(&scale).iter().copied().collect();
    let residual = |(row, target): &(Vec<f64>, f64)| -> f64 {
        target - row.iter().zip(&coefficients).map(|(a, b)| a * b).sum::<f64>()
    };
    let squares = rows.iter().map(|row| residual(row).powi(2)).sum();
    let mean = rows.iter().map(|row| row.1).sum::<f64>() / rows.len() as f64;
    let spread = rows.iter().map(|row| (row.1 - mean).powi(2)).sum();
    coefficients.iter().all(|value| value.is_finite()).then_some(Regression { coefficients, squares, spread })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_plane_is_recovered_and_a_line_alone_has_no_unique_plane() {
        let rows = |other: fn(f64) -> f64| -> Vec<(Vec<f64>, f64)> {
            (0..20).map(f64::from).map(|x| (vec![1.0, x, other(x)], 2.0 - 3.0 * x + 0.5 * other(x))).collect()
        };
        let found = regression(&rows(|x| x * x)).expect("a plane");
        for (value, truth) in found.coefficients.iter().zip([2.0, -3.0, 0.5]) {
            assert!((value - truth).abs() < 1e-9, "{value} against {truth}");
        }
        assert!(found.squares < 1e-12 && found.explains_enough());
        assert!(regression(&rows(|_| 0.0)).is_none());
        assert!(regression(&[]).is_none());
    }
}
