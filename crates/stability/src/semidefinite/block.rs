use nalgebra::{DMatrix, DVector};
use std::f64::consts::{FRAC_1_SQRT_2, SQRT_2};

use super::small::{times, times_transposed, transposed_times};
use super::triangle::{entries, row, symmetric};

/// `f Mᵀ Z M`, with `Z` one of the unknown symmetric matrices.
#[derive(Debug, Clone)]
pub(in super::super) struct Congruence {
    pub(in super::super) factor: f64,
    /// Column by column from here.
    pub(in super::super) start: usize,
    pub(in super::super) map: DMatrix<f64>,
}

/// `Σ f Mᵀ Z M + Σ y_i A_i`.
#[derive(Debug, Clone)]
pub(in super::super) struct Block {
    pub(in super::super) size: usize,
    pub(in super::super) congruences: Vec<Congruence>,
    pub(in super::super) loose: Vec<(usize, DMatrix<f64>)>,
}

pub(in super::super) fn matrix_at(y: &DVector<f64>, start: usize, size: usize) -> DMatrix<f64> {
    DMatrix::from_fn(size, size, |i, j| y[start + row(i.min(j), i.max(j))])
}

fn twice_off_diagonal(p: usize, q: usize) -> f64 {
    if p == q { 1.0 } else { 2.0 }
}

impl Block {
    pub(super) fn image(&self, y: &DVector<f64>) -> DMatrix<f64> {
        let mut sum = DMatrix::zeros(self.size, self.size);
        for Congruence { factor, start, map } in &self.congruences {
            let z = matrix_at(y, *start, map.nrows());
            sum += transposed_times(map, &times(&z, map)) * *factor;
        }
        for (variable, matrix) in &self.loose {
            sum += matrix * y[*variable];
        }
        symmetric(&sum)
    }

    /// Adds `<A_i, X>` to row `i`.
    pub(super) fn add_adjoint(&self, x: &DMatrix<f64>, rows: &mut DVector<f64>) {
        for Congruence { factor, start, map } in &self.congruences {
            let product = times_transposed(&times(map, x), map);
            for q in 0..map.nrows() {
                for p in 0..=q {
                    rows[start + row(p, q)] += factor * twice_off_diagonal(p, q) * product[(p, q)];
                }
            }
        }
        for (variable, matrix) in &self.loose {
            rows[*variable] += matrix.dot(x);
        }
    }

    /// Adds `<Gᵀ A_i G, Gᵀ A_j G>` as the sum of `h` and its transpose.
    ///
    /// With `N = M G` and `Q = N N'ᵀ` the entry for `Z_pq` and `Z'_rs` is `Q_pr Q_qs + Q_ps Q_qr`, without a matrix per
    /// variable.
    #[allow(
        clippy::needless_range_loop,
        reason = "adapters of iterators are calls if they are compiled in another unit"
    )]
    pub(super) fn add_gram(&self, g: &DMatrix<f64>, h: &mut DMatrix<f64>) {
        let scaled: Vec<DMatrix<f64>> = self.congruences.iter().map(|one| times(&one.map, g)).collect();
        let weight = |p: usize, q: usize| if p == q { FRAC_1_SQRT_2 } else { SQRT_2 };
        for (k, a) in self.congruences.iter().enumerate() {
            for (l, b) in self.congruences.iter().enumerate().take(k + 1) {
                let product = times_transposed(&scaled[k], &scaled[l]);
                let (rows, n) = (product.as_slice(), a.map.nrows());
                // The sum with the transpose counts a diagonal block twice.
                let factor = a.factor * b.factor * if k == l { 0.5 } else { 1.0 };
                for s in 0..b.map.nrows() {
                    let of_s = &rows[s * n..(s + 1) * n];
                    for r in 0..=s {
                        let of_r = &rows[r * n..(r + 1) * n];
                        let outer = factor * weight(r, s) * SQRT_2;
                        let to = (b.start + row(r, s)) * h.nrows() + a.start;
                        let column = &mut h.as_mut_slice()[to..to + entries(n)];
                        for q in 0..n {
                            let (x, y) = (outer * of_s[q], outer * of_r[q]);
                            let target = &mut column[row(0, q)..=row(q, q)];
                            let (u, v) = (&of_r[..=q], &of_s[..=q]);
                            for p in 0..=q {
                                target[p] += u[p] * x + v[p] * y;
                            }
                            target[q] -= (1.0 - FRAC_1_SQRT_2 / SQRT_2) * (of_r[q] * x + of_s[q] * y);
                        }
                    }
                }
            }
        }
        let loose: Vec<DMatrix<f64>> =
            self.loose.iter().map(|(_, matrix)| transposed_times(g, &times(matrix, g))).collect();
        for (k, (variable, _)) in self.loose.iter().enumerate() {
            for (l, (other, _)) in self.loose.iter().enumerate() {
                h[(*variable, *other)] += 0.5 * loose[k].dot(&loose[l]);
            }
            for (one, n) in self.congruences.iter().zip(&scaled) {
                let product = times_transposed(&times(n, &loose[k]), n);
                for q in 0..one.map.nrows() {
                    for p in 0..=q {
                        let entry = one.factor * twice_off_diagonal(p, q) * product[(p, q)];
                        h[(*variable, one.start + row(p, q))] += entry;
                    }
                }
            }
        }
    }
}

pub(in super::super) fn starts(sizes: impl IntoIterator<Item = usize>) -> (Vec<usize>, usize) {
    let (mut starts, mut next) = (vec![], 0);
    for size in sizes {
        starts.push(next);
        next += entries(size);
    }
    (starts, next)
}
