use nalgebra::DMatrix;

use super::linear_algebra::{check_finite, check_size, eigenvalues, product, solve, solve_right};
use super::{Complex64, Continuous, Discrete, Domain, Error};

/// `x' = A x + B u`, `y = C x + D u` (or `x_{k+1} = A x_k + B u_k`) with n states, m inputs and p outputs, possibly 0.
///
/// Connecting a continuous system to a discrete one does not compile:
///
/// ```compile_fail
/// # mod trocar { pub use trocar_lti as lti; }
/// use nalgebra::dmatrix;
/// use trocar::lti::{StateSpace, series};
/// let m = || dmatrix![1.0];
/// let continuous = StateSpace::continuous(m(), m(), m(), m()).unwrap();
/// let discrete = StateSpace::discrete(m(), m(), m(), m(), 1e-3).unwrap();
/// let _ = series(&continuous, &discrete); // expected `StateSpace<Continuous>`, found `StateSpace<Discrete>`
/// ```
///
/// Two continuous systems compile:
///
/// ```
/// # mod trocar { pub use trocar_lti as lti; }
/// use nalgebra::dmatrix;
/// use trocar::lti::{StateSpace, series};
/// let m = || dmatrix![1.0];
/// let continuous = StateSpace::continuous(m(), m(), m(), m())?;
/// let _ = series(&continuous, &continuous)?;
/// # Ok::<(), trocar::lti::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct StateSpace<D: Domain> {
    a: DMatrix<f64>,
    b: DMatrix<f64>,
    c: DMatrix<f64>,
    d: DMatrix<f64>,
    domain: D,
}

impl StateSpace<Continuous> {
    /// A (n x n), B (n x m), C (p x n), D (p x m).
    pub fn continuous(a: DMatrix<f64>, b: DMatrix<f64>, c: DMatrix<f64>, d: DMatrix<f64>) -> Result<Self, Error> {
        Self::new(a, b, c, d, Continuous)
    }
}

impl StateSpace<Discrete> {
    pub fn discrete(
        a: DMatrix<f64>,
        b: DMatrix<f64>,
        c: DMatrix<f64>,
        d: DMatrix<f64>,
        tick_s: f64,
    ) -> Result<Self, Error> {
        Self::new(a, b, c, d, Discrete::new(tick_s)?)
    }

    pub fn tick_s(&self) -> f64 {
        self.domain.tick_s()
    }
}

impl<D: Domain> StateSpace<D> {
    pub fn new(a: DMatrix<f64>, b: DMatrix<f64>, c: DMatrix<f64>, d: DMatrix<f64>, domain: D) -> Result<Self, Error> {
        let n = a.nrows();
        check_size("the number of columns of A", n, a.ncols())?;
        check_size("the number of rows of B", n, b.nrows())?;
        check_size("the number of columns of C", n, c.ncols())?;
        check_size("the number of rows of D", c.nrows(), d.nrows())?;
        check_size("the number of columns of D", b.ncols(), d.ncols())?;
        for (what, matrix) in [("A", &a), ("B", &b), ("C", &c), ("D", &d)] {
            check_finite(what, matrix.as_slice())?;
        }
        Ok(Self { a, b, c, d, domain })
    }

    /// `y = D u`.
    pub fn gain(d: DMatrix<f64>, domain: D) -> Result<Self, Error> {
        let (p, m) = d.shape();
        Self::new(DMatrix::zeros(0, 0), DMatrix::zeros(0, m), DMatrix::zeros(p, 0), d, domain)
    }

    pub fn a(&self) -> &DMatrix<f64> {
        &self.a
    }

    pub fn b(&self) -> &DMatrix<f64> {
        &self.b
    }

    pub fn c(&self) -> &DMatrix<f64> {
        &self.c
    }

    pub fn d(&self) -> &DMatrix<f64> {
        &self.d
    }

    pub fn domain(&self) -> D {
        self.domain
    }

    pub fn states(&self) -> usize {
        self.a.nrows()
    }

    pub fn inputs(&self) -> usize {
        self.b.ncols()
    }

    pub fn outputs(&self) -> usize {
        self.c.nrows()
    }

    /// Sorted by real, then imaginary part; in 1/s for a continuous system.
    pub fn poles(&self) -> Result<Vec<Complex64>, Error> {
        eigenvalues(&self.a)
    }

    /// True if every mode decays, even unobservable ones.
    pub fn is_stable(&self) -> Result<bool, Error> {
        Ok(self.poles()?.into_iter().all(|pole| self.domain.is_stable_pole(pole)))
    }

    /// `H(s) = C (s I - A)⁻¹ B + D` at s or z, p x m.
    pub fn evaluate(&self, s: Complex64) -> Result<DMatrix<Complex64>, Error> {
        let complex = |m: &DMatrix<f64>| m.map(|v| Complex64::new(v, 0.0));
        if self.states() == 0 {
            return Ok(complex(&self.d));
        }
        let mut shifted = -complex(&self.a);
        for i in 0..self.states() {
            shifted[(i, i)] += s;
        }
        shifted
            .lu()
            .solve(&complex(&self.b))
            .map(|x| complex(&self.c) * x + complex(&self.d))
            .filter(|h| h.iter().all(|v| v.re.is_finite() && v.im.is_finite()))
            .ok_or(Error::AtPole { re: s.re, im: s.im })
    }

    /// `C (c I - A)⁻¹ B + D` with c = 0 (s) or 1 (z), p x m. `None` with an integrating mode, even an unobservable one.
    pub fn dc_gain(&self) -> Option<DMatrix<f64>> {
        let n = self.states();
        let shifted = DMatrix::identity(n, n) * self.domain.constant_point() - &self.a;
        Some(product(&self.c, &solve(&shifted, &self.b)?) + &self.d)
    }

    /// `(T A T⁻¹, T B, C T⁻¹, D)`, with the states `z = T x`.
    pub fn transform(&self, t: &DMatrix<f64>) -> Result<Self, Error> {
        let n = self.states();
        check_size("the number of rows of T", n, t.nrows())?;
        check_size("the number of columns of T", n, t.ncols())?;
        check_finite("T", t.as_slice())?;
        let singular = || Error::Singular { what: "the transformation", size: n };
        let a = solve_right(t, &product(t, &self.a)).ok_or_else(singular)?;
        let c = solve_right(t, &self.c).ok_or_else(singular)?;
        Self::new(a, product(t, &self.b), c, self.d.clone(), self.domain)
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::dmatrix;

    use super::*;

    fn lag() -> StateSpace<Continuous> {
        StateSpace::continuous(dmatrix![-2.0], dmatrix![3.0], dmatrix![1.0], dmatrix![0.5]).expect("well formed")
    }

    #[test]
    fn shapes_are_checked_by_name() {
        let wrong = StateSpace::continuous(dmatrix![1.0], dmatrix![1.0; 2.0], dmatrix![1.0], dmatrix![1.0]);
        let expected = Error::DimensionMismatch { what: "the number of rows of B", expected: 1, found: 2 };
        assert_eq!(wrong, Err(expected));
        let bad_tick = StateSpace::discrete(dmatrix![1.0], dmatrix![1.0], dmatrix![1.0], dmatrix![1.0], 0.0);
        assert_eq!(bad_tick, Err(Error::TickNotPositive { tick_s: 0.0 }));
    }

    #[test]
    fn a_lag_has_the_response_of_its_closed_form() {
        assert_eq!(lag().dc_gain().expect("finite"), dmatrix![2.0]);
        assert_eq!(lag().poles().expect("converges"), [Complex64::new(-2.0, 0.0)]);
        assert!(lag().is_stable().expect("converges"));
        let at_2j = lag().evaluate(Complex64::new(0.0, 2.0)).expect("regular")[(0, 0)];
        assert!((at_2j - Complex64::new(1.25, -0.75)).norm() < 1e-15);
        assert_eq!(lag().evaluate(Complex64::new(-2.0, 0.0)), Err(Error::AtPole { re: -2.0, im: 0.0 }));
    }

    #[test]
    fn an_integrator_has_no_dc_gain() {
        let integrator = StateSpace::continuous(dmatrix![0.0], dmatrix![1.0], dmatrix![1.0], dmatrix![0.0]);
        assert_eq!(integrator.expect("well formed").dc_gain(), None);
    }

    #[test]
    fn a_gain_has_no_states() {
        let gain = StateSpace::gain(dmatrix![2.0, 3.0], Continuous).expect("finite");
        assert_eq!((gain.states(), gain.inputs(), gain.outputs()), (0, 2, 1));
        assert_eq!(gain.dc_gain().expect("finite"), dmatrix![2.0, 3.0]);
        assert!(gain.poles().expect("none").is_empty());
    }

    #[test]
    fn a_singular_transformation_is_rejected() {
        assert_eq!(lag().transform(&dmatrix![0.0]), Err(Error::Singular { what: "the transformation", size: 1 }));
        assert_eq!(lag().transform(&dmatrix![4.0]).expect("regular").b()[(0, 0)], 12.0);
    }
}
