use std::ops::{Add, Mul, Neg, Sub};

use super::{Complex64, Error, Polynomial};

/// `N(s) / D(s)` in continuous time, also improper, like the arm of eq. 32.
///
/// Only [`minimal`](Self::minimal) cancels common roots, because that could hide unstable modes.
#[derive(Debug, Clone, PartialEq)]
pub struct TransferFunction {
    numerator: Polynomial,
    denominator: Polynomial,
}

impl TransferFunction {
    /// From descending powers, as printed: `new(&[1.0], &[0.245, 4.1, 0.0])` is eq. 28.
    pub fn new(numerator: &[f64], denominator: &[f64]) -> Result<Self, Error> {
        let ratio = Self::from_polynomials(Polynomial::new(numerator)?, Polynomial::new(denominator)?)?;
        if denominator.first() == Some(&0.0) {
            return Err(Error::ZeroLeadingDenominator { degree: denominator.len() - 1 });
        }
        Ok(ratio)
    }

    pub fn from_polynomials(numerator: Polynomial, denominator: Polynomial) -> Result<Self, Error> {
        if denominator.is_zero() { Err(Error::ZeroDenominator) } else { Ok(Self { numerator, denominator }) }
    }

    pub fn gain(value: f64) -> Result<Self, Error> {
        Self::new(&[value], &[1.0])
    }

    pub fn numerator(&self) -> &Polynomial {
        &self.numerator
    }

    pub fn denominator(&self) -> &Polynomial {
        &self.denominator
    }

    pub fn relative_degree(&self) -> Option<i64> {
        Some(self.denominator.degree()? as i64 - self.numerator.degree()? as i64)
    }

    pub fn is_proper(&self) -> bool {
        self.relative_degree().is_none_or(|degree| degree >= 0)
    }

    /// Infinite or NaN at a pole.
    pub fn evaluate(&self, s: Complex64) -> Complex64 {
        self.numerator.evaluate_complex(s) / self.denominator.evaluate_complex(s)
    }

    /// The limit at s = 0, with factors of s cancelled; `None` if infinite.
    pub fn dc_gain(&self) -> Option<f64> {
        if self.numerator.is_zero() {
            return Some(0.0);
        }
        let (above, below) = (self.numerator.roots_at_zero(), self.denominator.roots_at_zero());
        match above.cmp(&below) {
            std::cmp::Ordering::Greater => Some(0.0),
            std::cmp::Ordering::Equal => Some(self.numerator.coefficient(above) / self.denominator.coefficient(below)),
            std::cmp::Ordering::Less => None,
        }
    }

    /// In 1/s, including roots that zeros would cancel.
    pub fn poles(&self) -> Result<Vec<Complex64>, Error> {
        self.denominator.roots()
    }

    /// In 1/s.
    pub fn zeros(&self) -> Result<Vec<Complex64>, Error> {
        self.numerator.roots()
    }

    pub fn inverse(&self) -> Result<Self, Error> {
        Self::from_polynomials(self.denominator.clone(), self.numerator.clone())
            .map_err(|_| Error::ZeroTransferFunction)
    }

    /// Negative feedback through `back`: `H / (1 + H G) = N D_g / (D D_g + N N_g)`.
    pub fn feedback(&self, back: &Self) -> Result<Self, Error> {
        let numerator = &self.numerator * &back.denominator;
        let denominator = &(&self.denominator * &back.denominator) + &(&self.numerator * &back.numerator);
        Self::from_polynomials(numerator, denominator).map_err(|_| Error::AlgebraicLoop { size: 1 })
    }

    /// Cancels a zero and a pole within `tolerance · max(1, |pole|)` of each other; `1e-6` suits printed coefficients.
    ///
    /// Common roots of multiplicity m are accurate to about ε^(1/m), so cancel after each operation. Check
    /// [`poles`](Self::poles) first: cancelling an unstable pole hides an instability.
    pub fn minimal(&self, tolerance: f64) -> Result<Self, Error> {
        let Some(leading) = self.numerator.leading() else {
            let denominator = Polynomial::constant(1.0)?;
            return Self::from_polynomials(self.numerator.clone(), denominator);
        };
        let at_zero = self.numerator.roots_at_zero().min(self.denominator.roots_at_zero());
        let numerator = self.numerator.without_lowest(at_zero);
        let denominator = self.denominator.without_lowest(at_zero);
        let upper = |p: &Polynomial| Ok(p.roots()?.into_iter().filter(|r| r.im >= 0.0).collect::<Vec<_>>());
        let mut zeros = upper(&numerator)?;
        let mut poles = Vec::new();
        let mut cancelled = false;
        for pole in upper(&denominator)? {
            let near = zeros
                .iter()
                .enumerate()
                .filter(|(_, zero)| (zero.im == 0.0) == (pole.im == 0.0))
                .map(|(i, zero)| (i, (zero - pole).norm()))
                .min_by(|a, b| a.1.total_cmp(&b.1))
                .filter(|(_, distance)| *distance <= tolerance * pole.norm().max(1.0));
            match near {
                Some((i, _)) => {
                    zeros.remove(i);
                    cancelled = true;
                }
                None => poles.push(pole),
            }
        }
        if !cancelled {
            return Self::from_polynomials(numerator, denominator);
        }
        let lower = denominator.leading().ok_or(Error::ZeroDenominator)?;
        Self::from_polynomials(
            Polynomial::from_roots(leading, &with_conjugates(&zeros))?,
            Polynomial::from_roots(lower, &with_conjugates(&poles))?,
        )
    }
}

fn with_conjugates(upper: &[Complex64]) -> Vec<Complex64> {
    let pair = |r: &Complex64| {
        if r.im == 0.0 { vec![*r] } else { vec![*r, r.conj()] }
    };
    upper.iter().flat_map(pair).collect()
}

impl Add for &TransferFunction {
    type Output = TransferFunction;

    fn add(self, other: Self) -> TransferFunction {
        TransferFunction {
            numerator: &(&self.numerator * &other.denominator) + &(&other.numerator * &self.denominator),
            denominator: &self.denominator * &other.denominator,
        }
    }
}

impl Neg for &TransferFunction {
    type Output = TransferFunction;

    fn neg(self) -> TransferFunction {
        TransferFunction { numerator: -&self.numerator, denominator: self.denominator.clone() }
    }
}

impl Sub for &TransferFunction {
    type Output = TransferFunction;

    fn sub(self, other: Self) -> TransferFunction {
        self + &-other
    }
}

impl Mul for &TransferFunction {
    type Output = TransferFunction;

    fn mul(self, other: Self) -> TransferFunction {
        TransferFunction {
            numerator: &self.numerator * &other.numerator,
            denominator: &self.denominator * &other.denominator,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tf(numerator: &[f64], denominator: &[f64]) -> TransferFunction {
        TransferFunction::new(numerator, denominator).expect("well formed")
    }

    #[test]
    fn malformed_denominators_are_named() {
        assert_eq!(TransferFunction::new(&[1.0], &[0.0]), Err(Error::ZeroDenominator));
        assert_eq!(TransferFunction::new(&[1.0], &[]), Err(Error::ZeroDenominator));
        assert_eq!(TransferFunction::new(&[1.0], &[0.0, 1.0]), Err(Error::ZeroLeadingDenominator { degree: 1 }));
        assert_eq!(tf(&[0.0], &[1.0]).inverse(), Err(Error::ZeroTransferFunction));
    }

    #[test]
    fn degrees_and_gains_follow_from_the_coefficients() {
        assert_eq!(tf(&[1.0], &[0.245, 4.1, 0.0]).relative_degree(), Some(2));
        assert_eq!(tf(&[1.0], &[0.245, 4.1, 0.0]).dc_gain(), None);
        assert!(!tf(&[1.0, 0.0], &[2.0]).is_proper());
        assert_eq!(tf(&[1.0, 0.0], &[2.0, 0.0]).dc_gain(), Some(0.5));
        assert_eq!(tf(&[0.0], &[1.0, 0.0]).dc_gain(), Some(0.0));
    }

    #[test]
    fn feedback_of_an_integrator_is_a_lag() {
        let lag = tf(&[3.0], &[1.0, 0.0]).feedback(&tf(&[1.0], &[1.0])).expect("regular");
        assert_eq!(lag, tf(&[3.0], &[1.0, 3.0]));
        let minus = tf(&[-1.0], &[1.0]);
        assert_eq!(minus.feedback(&tf(&[1.0], &[1.0])), Err(Error::AlgebraicLoop { size: 1 }));
    }

    #[test]
    fn only_close_real_and_paired_roots_cancel() {
        let common = tf(&[1.0, 2.0, 10.0, 0.0], &[1.0, 2.0, 10.0, 0.0]);
        let plain = tf(&[2.0, 14.0], &[1.0, 3.0, 1.0]);
        let short = (&plain * &common).minimal(1e-6).expect("converges");
        assert_eq!(short.relative_degree(), Some(1));
        for (a, b) in short.denominator().coefficients().iter().zip([1.0, 3.0, 1.0]) {
            assert!((a - b).abs() < 1e-9);
        }
        assert_eq!(plain.minimal(1e-6).expect("converges"), plain);
    }
}
