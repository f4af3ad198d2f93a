use nalgebra::{DMatrix, DVector, Hessenberg};

use super::side::{MAX_STATES, Side};
use trocar_lti::Complex64;

/// Relative size of rounding errors.
const ROUNDING: f64 = 1e-15;

/// `H(z) = c (z I - A)⁻¹ (b_now + b_before / z)`; with `b_before` the last sample is an additional state.
///
/// `A` has Hessenberg form with an input on the first state only. From the last state on, each row gives the state
/// above it, and the first row the input (Hyman's method; Wilkinson 1965, *The algebraic eigenvalue problem*).
#[derive(Debug, Clone)]
pub(super) struct Response {
    n: usize,
    a: [[f64; MAX_STATES]; MAX_STATES],
    /// Reciprocals of the subdiagonal entries, by row.
    above: [f64; MAX_STATES],
    input: f64,
    c: [f64; MAX_STATES],
}

impl Response {
    pub(super) fn new(side: &Side) -> Self {
        let (mut a, b, c) = side.with_held();
        let n = a.nrows();
        let scales = nalgebra::linalg::balancing::balance_parlett_reinsch(&mut a);
        let mut b = b.component_div(&scales);
        let mut c = c.component_mul(&scales);
        // The reflection leaves the input on the first state only.
        let input = if b[0] > 0.0 { -b.norm() } else { b.norm() };
        b[0] -= input;
        let size = b.norm_squared();
        if size > 0.0 {
            let rows = b.tr_mul(&a) * (2.0 / size);
            a -= &b * rows;
            let columns = &a * &b * (2.0 / size);
            a -= columns * b.transpose();
            c -= &b * (2.0 * b.dot(&c) / size);
        }
        let (q, h): (DMatrix<f64>, DMatrix<f64>) =
            if n > 1 { Hessenberg::new(a).unpack() } else { (DMatrix::identity(n, n), a) };
        // The Hessenberg form can only change the sign of the first state.
        let input = input * q[(0, 0)];
        let c: DVector<f64> = q.tr_mul(&c);
        let rounding = ROUNDING * h.amax();
        // The input reaches only these states.
        let reached = (1..n).find(|&k| h[(k, k - 1)].abs() <= rounding).unwrap_or(n);
        let entry = |i: usize, j: usize| if i < reached && j < reached { h[(i, j)] } else { 0.0 };
        Self {
            n: reached,
            a: std::array::from_fn(|i| std::array::from_fn(|j| entry(i, j))),
            above: std::array::from_fn(|k| if 0 < k && k < reached { h[(k, k - 1)].recip() } else { 0.0 }),
            input,
            c: std::array::from_fn(|k| if k < reached { c[k] } else { 0.0 }),
        }
    }

    pub(super) fn at(&self, z: Complex64) -> Complex64 {
        let mut x = [Complex64::new(0.0, 0.0); MAX_STATES];
        let last = self.n - 1;
        x[last] = Complex64::new(1.0, 0.0);
        let mut sum = x[last] * self.c[last];
        let row = |k: usize, x: &[Complex64; MAX_STATES]| {
            let of_states = x[k..self.n].iter().zip(&self.a[k][k..self.n]);
            of_states.fold(z * x[k], |rest, (state, weight)| rest - state * weight)
        };
        for k in (1..self.n).rev() {
            x[k - 1] = row(k, &x) * self.above[k];
            sum += x[k - 1] * self.c[k - 1];
        }
        sum * self.input / row(0, &x)
    }

    pub(super) fn relative_slope_at(&self, z: Complex64) -> Complex64 {
        let zero = Complex64::new(0.0, 0.0);
        let (mut x, mut slopes) = ([zero; MAX_STATES], [zero; MAX_STATES]);
        let last = self.n - 1;
        x[last] = Complex64::new(1.0, 0.0);
        let (mut sum, mut sum_slope) = (x[last] * self.c[last], zero);
        let row = |k: usize, values: &[Complex64; MAX_STATES]| {
            let of_states = values[k..self.n].iter().zip(&self.a[k][k..self.n]);
            of_states.fold(z * values[k], |rest, (state, weight)| rest - state * weight)
        };
        for k in (1..self.n).rev() {
            (x[k - 1], slopes[k - 1]) = (row(k, &x) * self.above[k], (x[k] + row(k, &slopes)) * self.above[k]);
            sum += x[k - 1] * self.c[k - 1];
            sum_slope += slopes[k - 1] * self.c[k - 1];
        }
        sum_slope / sum - (x[0] + row(0, &slopes)) / row(0, &x)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::side::External;

    #[test]
    fn the_relative_slope_agrees_with_neighbouring_responses() {
        let a = DMatrix::from_row_slice(3, 3, &[0.9, 0.1, 0.0, -0.2, 0.8, 0.05, 0.0, 0.3, 0.5]);
        let (now, c) = (DVector::from_row_slice(&[0.1, 0.4, -0.2]), DVector::from_row_slice(&[1.0, 0.5, 2.0]));
        for before in [None, Some(DVector::from_row_slice(&[0.3, 0.0, 0.1]))] {
            let local = DVector::zeros(3);
            let side = Side {
                a: a.clone(),
                now: now.clone(),
                before,
                c: c.clone(),
                force: local.clone(),
                local,
                desired: None,
                external: External::none(3),
            };
            let response = Response::new(&side);
            for angle in [0.0, 0.3, 2.0] {
                let z = Complex64::from_polar(1.0, angle);
                let step = Complex64::new(1e-6, 0.0);
                let difference = (response.at(z + step) - response.at(z - step)) / (2.0 * step);
                let expected = difference / response.at(z);
                assert!((response.relative_slope_at(z) - expected).norm() < 1e-8 * (1.0 + expected.norm()));
            }
        }
    }
}
