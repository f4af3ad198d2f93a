//! Nesterov-Todd scaling: a matrix and its multiplier become the same diagonal matrix.

use nalgebra::{Cholesky, DMatrix, DVector, SymmetricEigen};

use super::small::{times, times_transposed, transposed_times};
use super::triangle::symmetric;

const MAX_SWEEPS: usize = 10_000;

/// `Gᵀ S G = G⁻¹ X G⁻ᵀ = diag(λ)`.
pub(super) struct Scaling {
    g: DMatrix<f64>,
    pub(super) lambda: DVector<f64>,
}

impl Scaling {
    /// With `S = L Lᵀ` and `Lᵀ X L = Q D Qᵀ`, `G = L⁻ᵀ Q D^¼` and `λ = D^½`; `None` if rounding makes `S` or `X`
    /// indefinite.
    pub(super) fn new(s: &DMatrix<f64>, x: &DMatrix<f64>) -> Option<Self> {
        let l = Cholesky::new(s.clone())?.unpack();
        let found = eigen(symmetric(&(l.transpose() * x * &l)))?;
        if found.eigenvalues.min() <= 0.0 {
            return None;
        }
        let mut g = found.eigenvectors;
        if !l.tr_solve_lower_triangular_mut(&mut g) {
            return None;
        }
        let lambda = found.eigenvalues.map(f64::sqrt);
        for (mut column, value) in g.column_iter_mut().zip(lambda.iter()) {
            column *= value.sqrt();
        }
        Some(Self { g, lambda })
    }

    pub(super) fn identity(size: usize) -> Self {
        Self { g: DMatrix::identity(size, size), lambda: DVector::from_element(size, 1.0) }
    }

    pub(super) fn g(&self) -> &DMatrix<f64> {
        &self.g
    }

    pub(super) fn scaled(&self, a: &DMatrix<f64>) -> DMatrix<f64> {
        symmetric(&transposed_times(&self.g, &times(a, &self.g)))
    }

    pub(super) fn unscaled_multiplier(&self, x: &DMatrix<f64>) -> DMatrix<f64> {
        symmetric(&times_transposed(&times(&self.g, x), &self.g))
    }

    /// The `D` with `(Λ D + D Λ) / 2 = R`.
    pub(super) fn quotient(&self, r: &DMatrix<f64>) -> DMatrix<f64> {
        let lambda = &self.lambda;
        DMatrix::from_fn(r.nrows(), r.ncols(), |i, j| 2.0 * r[(i, j)] / (lambda[i] + lambda[j]))
    }

    /// The maximum `t` with a positive semidefinite `Λ + t D`.
    pub(super) fn longest_step(&self, d: &DMatrix<f64>) -> f64 {
        let root = self.lambda.map(f64::sqrt);
        let relative = DMatrix::from_fn(d.nrows(), d.ncols(), |i, j| d[(i, j)] / (root[i] * root[j]));
        match min_eigenvalue(relative) {
            Some(min) if min < 0.0 => -1.0 / min,
            Some(_) => f64::INFINITY,
            None => 0.0,
        }
    }
}

fn eigen(matrix: DMatrix<f64>) -> Option<SymmetricEigen<f64, nalgebra::Dyn>> {
    if matrix.iter().any(|value| !value.is_finite()) {
        return None;
    }
    SymmetricEigen::try_new(matrix, f64::EPSILON, MAX_SWEEPS)
}

pub(super) fn min_eigenvalue(matrix: DMatrix<f64>) -> Option<f64> {
    matrix.iter().all(|value| value.is_finite()).then(|| matrix.symmetric_eigenvalues().min())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn positive(n: usize, seed: f64) -> DMatrix<f64> {
        let root = DMatrix::from_fn(n, n, |i, j| (seed * (7 * i + 13 * j + i * j) as f64).sin());
        &root * root.transpose() + DMatrix::identity(n, n) * 0.01
    }

    #[test]
    fn both_matrices_are_scaled_to_the_same_diagonal_matrix() {
        for n in [1, 2, 7] {
            let (s, x) = (positive(n, 1.7), positive(n, 0.9));
            let scaling = Scaling::new(&s, &x).expect("positive definite");
            let lambda = DMatrix::from_diagonal(&scaling.lambda);
            assert!((scaling.g.transpose() * &s * &scaling.g - &lambda).norm() < 1e-12);
            assert!((scaling.unscaled_multiplier(&lambda) - &x).norm() < 1e-12);
            assert!((scaling.scaled(&s) - &lambda).norm() < 1e-12);
            let r = positive(n, 0.3);
            let d = scaling.quotient(&r);
            assert!(((&lambda * &d + &d * &lambda) * 0.5 - r).norm() < 1e-12);
        }
        assert!(Scaling::new(&-positive(2, 1.0), &positive(2, 1.0)).is_none());
    }

    #[test]
    fn the_longest_step_ends_where_an_eigenvalue_is_zero() {
        let scaling = Scaling::new(&positive(4, 1.7), &positive(4, 0.9)).expect("positive definite");
        let d = DMatrix::from_fn(4, 4, |i, j| ((i + j) as f64).cos());
        let end = DMatrix::from_diagonal(&scaling.lambda) + &d * scaling.longest_step(&d);
        assert!(end.symmetric_eigenvalues().min().abs() < 1e-12);
        assert_eq!(scaling.longest_step(&DMatrix::identity(4, 4)), f64::INFINITY);
    }
}
