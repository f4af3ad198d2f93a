//! The response of a side at a complex point, fast enough for millions of evaluations.

use nalgebra::{DMatrix, DVector, Hessenberg};

use super::side::Side;
use crate::lti::Complex64;

/// Maximum states of a side.
const MAX_STATES: usize = 10;

/// `H(z) = c (z I - A)⁻¹ (b_now + b_before / z)` with `A` balanced and in Hessenberg form, so that a point costs O(n²),
/// and states of different scales do no harm.
#[derive(Debug, Clone)]
pub(super) struct Response {
    n: usize,
    a: [[f64; MAX_STATES]; MAX_STATES],
    now: [f64; MAX_STATES],
    before: [f64; MAX_STATES],
    c: [f64; MAX_STATES],
}

impl Response {
    pub(super) fn new(side: &Side) -> Self {
        let n = side.a.nrows();
        let mut balanced = side.a.clone();
        let scales = nalgebra::linalg::balancing::balance_parlett_reinsch(&mut balanced);
        let (q, h): (DMatrix<f64>, DMatrix<f64>) =
            if n > 1 { Hessenberg::new(balanced).unpack() } else { (DMatrix::identity(n, n), balanced) };
        let rows = |vector: &DVector<f64>| q.transpose() * vector.component_div(&scales);
        let padded = |vector: &DVector<f64>| std::array::from_fn(|i| vector.get(i).copied().unwrap_or(0.0));
        let c = q.transpose() * side.c.component_mul(&scales);
        Self {
            n,
            a: std::array::from_fn(|i| std::array::from_fn(|j| if i < n && j < n { h[(i, j)] } else { 0.0 })),
            now: padded(&rows(&side.now)),
            before: side.before.as_ref().map_or([0.0; MAX_STATES], |before| padded(&rows(before))),
            c: padded(&c),
        }
    }

    /// The response at `z`; not finite at a pole.
    #[allow(clippy::needless_range_loop, reason = "rows and columns are numbered as in the elimination")]
    pub(super) fn at(&self, z: Complex64) -> Complex64 {
        let n = self.n;
        let zero = Complex64::new(0.0, 0.0);
        let inverse = z.inv();
        let mut rows = [[zero; MAX_STATES]; MAX_STATES];
        let mut right = [zero; MAX_STATES];
        for i in 0..n {
            for j in i.saturating_sub(1)..n {
                rows[i][j] = Complex64::new(-self.a[i][j], 0.0);
            }
            rows[i][i] += z;
            right[i] = inverse * self.before[i] + self.now[i];
        }
        for k in 0..n.saturating_sub(1) {
            if rows[k + 1][k].norm_sqr() > rows[k][k].norm_sqr() {
                rows.swap(k, k + 1);
                right.swap(k, k + 1);
            }
            if rows[k + 1][k] == zero {
                continue;
            }
            let factor = rows[k + 1][k] / rows[k][k];
            for j in k + 1..n {
                let above = rows[k][j];
                rows[k + 1][j] -= factor * above;
            }
            let above = right[k];
            right[k + 1] -= factor * above;
        }
        let mut sum = zero;
        for k in (0..n).rev() {
            let mut value = right[k];
            for j in k + 1..n {
                value -= rows[k][j] * right[j];
            }
            value /= rows[k][k];
            right[k] = value;
            sum += value * self.c[k];
        }
        sum
    }
}
