//! Interval arithmetic, rounded outwards by one step of a double (Moore, *Interval Analysis*; Rump, *Acta Numerica*
//! 2010).

use nalgebra::DMatrix;
use std::ops::{Add, Mul, Sub};

#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Interval {
    pub(crate) low: f64,
    pub(crate) high: f64,
}

impl Interval {
    pub(crate) fn exact(value: f64) -> Self {
        Self { low: value, high: value }
    }

    pub(crate) fn rounded(value: f64) -> Self {
        const ROUNDINGS: f64 = 16.0;
        let reach = (value.abs() * (ROUNDINGS * f64::EPSILON)).next_up();
        if value == 0.0 {
            Self::exact(0.0)
        } else {
            Self { low: (value - reach).next_down(), high: (value + reach).next_up() }
        }
    }

    fn is_zero(self) -> bool {
        self.low == 0.0 && self.high == 0.0
    }

    fn squared(self) -> Self {
        let (a, b) = (self.low.abs(), self.high.abs());
        let spans_zero = self.low <= 0.0 && self.high >= 0.0;
        let min = if spans_zero { 0.0 } else { (a.min(b) * a.min(b)).next_down() };
        Self { low: min.max(0.0), high: (a.max(b) * a.max(b)).next_up() }
    }

    pub(crate) fn over(self, divisor: Self) -> Self {
        let inverse = Self { low: (1.0 / divisor.high).next_down(), high: (1.0 / divisor.low).next_up() };
        self * inverse
    }
}

impl Add for Interval {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self { low: (self.low + other.low).next_down(), high: (self.high + other.high).next_up() }
    }
}

impl Sub for Interval {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        Self { low: (self.low - other.high).next_down(), high: (self.high - other.low).next_up() }
    }
}

impl Mul for Interval {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        if self.is_zero() || other.is_zero() {
            return Self::exact(0.0);
        }
        let (a, b) = (self.low * other.low, self.low * other.high);
        let (c, d) = (self.high * other.low, self.high * other.high);
        let (min, max) = (a.min(b).min(c.min(d)), a.max(b).max(c.max(d)));
        Self { low: min.next_down(), high: max.next_up() }
    }
}

pub(crate) type Enclosure = Vec<Vec<Interval>>;

pub(crate) fn rounded(matrix: &DMatrix<f64>) -> Enclosure {
    (0..matrix.nrows()).map(|i| (0..matrix.ncols()).map(|j| Interval::rounded(matrix[(i, j)])).collect()).collect()
}

pub(crate) fn exact(matrix: &DMatrix<f64>) -> Enclosure {
    (0..matrix.nrows()).map(|i| (0..matrix.ncols()).map(|j| Interval::exact(matrix[(i, j)])).collect()).collect()
}

#[allow(clippy::needless_range_loop, reason = "adapters of iterators are calls if they are compiled in another unit")]
pub(crate) fn product(a: &Enclosure, b: &Enclosure) -> Enclosure {
    let columns = b.first().map_or(0, Vec::len);
    let of_row = |row: &Vec<Interval>| {
        let mut sums = vec![Interval::exact(0.0); columns];
        for k in 0..row.len() {
            let (x, other) = (row[k], &b[k][..columns]);
            if !x.is_zero() {
                for j in 0..columns {
                    sums[j] = sums[j] + x * other[j];
                }
            }
        }
        sums
    };
    a.iter().map(of_row).collect()
}

/// `S⁻¹ A` for a lower triangular `S`.
pub(crate) fn solved(scale: &DMatrix<f64>, mut rows: Enclosure) -> Enclosure {
    for i in 0..rows.len() {
        for k in (0..i).filter(|&k| scale[(i, k)] != 0.0) {
            for j in 0..rows[i].len() {
                rows[i][j] = rows[i][j] - Interval::exact(scale[(i, k)]) * rows[k][j];
            }
        }
        for entry in &mut rows[i] {
            *entry = entry.over(Interval::exact(scale[(i, i)]));
        }
    }
    rows
}

pub(crate) fn sum(a: &Enclosure, b: &Enclosure) -> Enclosure {
    a.iter().zip(b).map(|(a, b)| a.iter().zip(b).map(|(x, y)| *x + *y).collect()).collect()
}

pub(crate) fn power(a: &Enclosure, mut n: u64) -> Enclosure {
    let one = DMatrix::identity(a.len(), a.len());
    let (mut result, mut base) = (exact(&one), a.clone());
    while n > 0 {
        if n % 2 == 1 {
            result = product(&result, &base);
        }
        n /= 2;
        if n > 0 {
            base = product(&base, &base);
        }
    }
    result
}

pub(crate) fn middle(a: &Enclosure) -> DMatrix<f64> {
    let columns = a.first().map_or(0, Vec::len);
    DMatrix::from_fn(a.len(), columns, |i, j| 0.5 * (a[i][j].low + a[i][j].high))
}

pub(crate) fn transpose(a: &Enclosure) -> Enclosure {
    let columns = a.first().map_or(0, Vec::len);
    (0..columns).map(|j| a.iter().map(|row| row[j]).collect()).collect()
}

/// False also if undecided.
pub(crate) fn is_positive_definite(matrix: &Enclosure) -> bool {
    let n = matrix.len();
    let mut rest = matrix.clone();
    // Scaling by powers of two is exact.
    let scales: Vec<f64> = (0..n).map(|k| (-0.5 * rest[k][k].high.abs().log2()).round().exp2()).collect();
    for (i, row) in rest.iter_mut().enumerate() {
        for (j, entry) in row.iter_mut().enumerate() {
            let scale = scales[i] * scales[j];
            *entry = Interval { low: entry.low * scale, high: entry.high * scale };
        }
    }
    for k in 0..n {
        let pivot = rest[k][k];
        // Also false for NaN.
        if !(pivot.low > 0.0 && pivot.high.is_finite()) {
            return false;
        }
        for i in k + 1..n {
            rest[i][i] = rest[i][i] - rest[i][k].squared().over(pivot);
            for j in k + 1..i {
                rest[i][j] = rest[i][j] - (rest[i][k] * rest[j][k]).over(pivot);
            }
        }
    }
    true
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_operation_encloses_the_exact_result() {
        // The exact results are not doubles.
        let (tenth, fifth) = (Interval::exact(0.1), Interval::exact(0.2));
        for result in [tenth + fifth, tenth * tenth, fifth - tenth, tenth.over(fifth)] {
            assert!(result.low < result.high && result.high - result.low < 1e-15);
        }
        let spans = Interval { low: -1.0, high: 2.0 };
        assert!(spans.squared().low == 0.0 && spans.squared().high >= 4.0);
        let product = spans * Interval { low: -3.0, high: 1.0 };
        assert!(product.low <= -6.0 && product.high >= 3.0);
        // The product of doubles is 0.
        assert!((Interval::exact(1e-200) * Interval::exact(1e-200)).high > 0.0);
    }

    #[test]
    fn a_matrix_with_a_negative_eigenvalue_is_not_positive_definite() {
        let hilbert = DMatrix::from_fn(5, 5, |i, j| 1.0 / (i + j + 1) as f64);
        assert!(is_positive_definite(&rounded(&hilbert)));
        let smallest = hilbert.symmetric_eigenvalues().min();
        let less = |share: f64| &hilbert - DMatrix::identity(5, 5) * (share * smallest);
        assert!(is_positive_definite(&exact(&less(0.999))));
        assert!(!is_positive_definite(&exact(&less(1.001))));
        let wide = hilbert.map(|value| Interval { low: value - smallest, high: value + smallest });
        let wide: Enclosure = (0..5).map(|i| (0..5).map(|j| wide[(i, j)]).collect()).collect();
        assert!(!is_positive_definite(&wide));
    }

    #[test]
    fn interval_powers_enclose_the_matrix_powers() {
        let a = DMatrix::from_row_slice(2, 2, &[0.9, 0.3, -0.2, 0.95]);
        let hundredth = power(&exact(&a), 100);
        let expected = (0..100).fold(DMatrix::identity(2, 2), |all, _| all * &a);
        for i in 0..2 {
            for j in 0..2 {
                let Interval { low, high } = hundredth[i][j];
                assert!(low <= expected[(i, j)] + 1e-14 && high >= expected[(i, j)] - 1e-14 && high - low < 1e-10);
            }
        }
    }
}
