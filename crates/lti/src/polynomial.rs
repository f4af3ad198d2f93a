use std::ops::{Add, Mul, Neg, Sub};

use nalgebra::DMatrix;

use super::linear_algebra::{check_finite, eigenvalues, sort};
use super::{Complex64, Error};

const NEWTON_STEPS: usize = 4;

/// `c_0 s^n + c_1 s^(n-1) + ... + c_n` with `c_0 ≠ 0`; the zero polynomial has no coefficients.
#[derive(Debug, Clone, PartialEq)]
pub struct Polynomial {
    descending: Vec<f64>,
}

impl Polynomial {
    /// From descending powers, with leading zeros trimmed: `[0.245, 4.1, 0.0]` is `0.245 s² + 4.1 s`.
    pub fn new(descending: &[f64]) -> Result<Self, Error> {
        check_finite("the polynomial", descending)?;
        Ok(Self::trimmed(descending.to_vec()))
    }

    pub fn constant(value: f64) -> Result<Self, Error> {
        Self::new(&[value])
    }

    /// `leading · Π (s - r_i)`; complex roots must form conjugate pairs.
    pub fn from_roots(leading: f64, roots: &[Complex64]) -> Result<Self, Error> {
        let mut product = vec![Complex64::new(leading, 0.0)];
        for root in roots {
            product.push(Complex64::new(0.0, 0.0));
            for i in (1..product.len()).rev() {
                let carried = product[i - 1] * root;
                product[i] -= carried;
            }
        }
        let real: Vec<f64> = product.iter().map(|c| c.re).collect();
        Self::new(&real)
    }

    fn trimmed(mut descending: Vec<f64>) -> Self {
        let leading_zeros = descending.iter().take_while(|c| **c == 0.0).count();
        descending.drain(..leading_zeros);
        Self { descending }
    }

    /// In descending powers; empty for the zero polynomial.
    pub fn coefficients(&self) -> &[f64] {
        &self.descending
    }

    /// `None` for the zero polynomial.
    pub fn leading(&self) -> Option<f64> {
        self.descending.first().copied()
    }

    pub fn coefficient(&self, power: usize) -> f64 {
        self.descending.iter().rev().nth(power).copied().unwrap_or(0.0)
    }

    pub fn degree(&self) -> Option<usize> {
        self.descending.len().checked_sub(1)
    }

    pub fn is_zero(&self) -> bool {
        self.descending.is_empty()
    }

    pub fn roots_at_zero(&self) -> usize {
        self.descending.iter().rev().take_while(|c| **c == 0.0).count()
    }

    pub fn scaled(&self, factor: f64) -> Self {
        Self::trimmed(self.descending.iter().map(|c| c * factor).collect())
    }

    pub fn evaluate(&self, x: f64) -> f64 {
        self.descending.iter().fold(0.0, |value, c| value * x + c)
    }

    pub fn evaluate_complex(&self, s: Complex64) -> Complex64 {
        self.descending.iter().fold(Complex64::new(0.0, 0.0), |value, c| value * s + c)
    }

    pub fn derivative(&self) -> Self {
        let powers = (1..self.descending.len()).rev();
        Self::trimmed(self.descending.iter().zip(powers).map(|(c, power)| c * power as f64).collect())
    }

    pub(super) fn without_lowest(&self, count: usize) -> Self {
        let kept = self.descending.len().saturating_sub(count);
        Self { descending: self.descending[..kept].to_vec() }
    }

    /// Sorted by real, then imaginary part; complex roots are exact conjugate pairs, roots at 0 exact.
    ///
    /// Eigenvalues of the companion matrix, refined by Newton steps; the relative accuracy of a root of multiplicity m
    /// is about ε^(1/m).
    pub fn roots(&self) -> Result<Vec<Complex64>, Error> {
        check_finite("the polynomial", &self.descending)?;
        let Some(degree) = self.degree() else {
            return Err(Error::ZeroPolynomial);
        };
        let at_zero = self.roots_at_zero();
        let rest = self.without_lowest(at_zero);
        let n = degree - at_zero;
        let mut roots = vec![Complex64::new(0.0, 0.0); at_zero];
        if n > 0 {
            let c = &rest.descending;
            let companion = DMatrix::from_fn(n, n, |i, j| match i {
                0 => -c[j + 1] / c[0],
                _ if i == j + 1 => 1.0,
                _ => 0.0,
            });
            let slope = rest.derivative();
            for guess in eigenvalues(&companion)?.into_iter().filter(|v| v.im >= 0.0) {
                let root = rest.refined(&slope, guess);
                roots.push(root);
                if root.im != 0.0 {
                    roots.push(root.conj());
                } else if guess.im != 0.0 {
                    roots.push(root); // a pair that Newton's method moved onto the real axis
                }
            }
        }
        sort(&mut roots);
        Ok(roots)
    }

    fn refined(&self, slope: &Self, mut root: Complex64) -> Complex64 {
        let mut value = self.evaluate_complex(root);
        for _ in 0..NEWTON_STEPS {
            let next = root - value / slope.evaluate_complex(root);
            let next_value = self.evaluate_complex(next);
            // Also false for NaN, at a multiple root.
            let lower = next_value.norm() < value.norm();
            if !lower {
                break;
            }
            (root, value) = (next, next_value);
        }
        root
    }
}

impl Add for &Polynomial {
    type Output = Polynomial;

    fn add(self, other: Self) -> Polynomial {
        let length = self.descending.len().max(other.descending.len());
        Polynomial::trimmed((0..length).rev().map(|power| self.coefficient(power) + other.coefficient(power)).collect())
    }
}

impl Neg for &Polynomial {
    type Output = Polynomial;

    fn neg(self) -> Polynomial {
        self.scaled(-1.0)
    }
}

impl Sub for &Polynomial {
    type Output = Polynomial;

    fn sub(self, other: Self) -> Polynomial {
        self + &-other
    }
}

impl Mul for &Polynomial {
    type Output = Polynomial;

    fn mul(self, other: Self) -> Polynomial {
        if self.is_zero() || other.is_zero() {
            return Polynomial { descending: Vec::new() };
        }
        let mut product = vec![0.0; self.descending.len() + other.descending.len() - 1];
        for (i, a) in self.descending.iter().enumerate() {
            for (j, b) in other.descending.iter().enumerate() {
                product[i + j] += a * b;
            }
        }
        Polynomial::trimmed(product)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn p(descending: &[f64]) -> Polynomial {
        Polynomial::new(descending).expect("finite")
    }

    #[test]
    fn leading_zeros_are_trimmed() {
        assert_eq!(p(&[0.0, 0.0, 2.0, 0.0]).coefficients(), [2.0, 0.0]);
        assert_eq!(p(&[0.0]).degree(), None);
        assert_eq!((&p(&[1.0, 2.0]) - &p(&[1.0, 1.0])).coefficients(), [1.0]);
    }

    #[test]
    fn small_polynomials_are_multiplied_differentiated_and_evaluated_exactly() {
        assert_eq!(&p(&[1.0, 1.0]) * &p(&[1.0, -1.0]), p(&[1.0, 0.0, -1.0]));
        assert_eq!(p(&[3.0, 2.0, 1.0]).derivative(), p(&[6.0, 2.0]));
        assert_eq!(p(&[1.0, 0.0, 1.0]).evaluate_complex(Complex64::new(0.0, 1.0)).norm(), 0.0);
        assert_eq!(p(&[2.0, 1.0]).evaluate(3.0), 7.0);
    }

    #[test]
    fn roots_at_zero_are_exact() {
        let roots = p(&[1.0, 3.0, 0.0, 0.0]).roots().expect("converges");
        assert_eq!(roots, [-3.0, 0.0, 0.0].map(|re| Complex64::new(re, 0.0)));
    }

    #[test]
    fn a_constant_has_no_roots_and_the_zero_polynomial_is_an_error() {
        assert!(p(&[4.0]).roots().expect("none").is_empty());
        assert_eq!(p(&[]).roots(), Err(Error::ZeroPolynomial));
        assert!(matches!(Polynomial::new(&[1.0, f64::NAN]), Err(Error::NonFinite { position: 1, .. })));
    }

    #[test]
    fn a_double_root_stays_close() {
        for root in p(&[1.0, 4.0, 4.0]).roots().expect("converges") {
            assert!((root + 2.0).norm() < 1e-7);
        }
    }
}
