use nalgebra::{DMatrix, DVector};

use super::linear_algebra::check_size;
use super::matrix_function::{exponential, logarithm};
use super::{Continuous, Discrete, Error, StateSpace};

#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum InputHold {
    /// Zero-order hold.
    Held,
    /// First-order (triangle) hold.
    Linear,
}

/// `x_{k+1} = Φ x_k + Γ_now u_k + Γ_next u_{k+1}`, the exact solution over one tick.
#[derive(Debug, Clone, PartialEq)]
pub struct ExactStep {
    /// `exp(A T)`, n x n.
    pub phi: DMatrix<f64>,
    /// n x m.
    pub gamma_now: DMatrix<f64>,
    /// n x m; the column of a held input is 0.
    pub gamma_next: DMatrix<f64>,
}

impl ExactStep {
    pub fn advance(
        &self,
        state: &DVector<f64>,
        now: &DVector<f64>,
        next: &DVector<f64>,
    ) -> Result<DVector<f64>, Error> {
        check_size("the length of the state", self.phi.ncols(), state.len())?;
        check_size("the length of the inputs now", self.gamma_now.ncols(), now.len())?;
        check_size("the length of the inputs next", self.gamma_next.ncols(), next.len())?;
        Ok(&self.phi * state + &self.gamma_now * now + &self.gamma_next * next)
    }
}

/// One matrix exponential contains all integrals (Van Loan, *Computing integrals involving the matrix exponential*,
/// 1978):
///
/// `exp([A T, B T, 0; 0, 0, I; 0, 0, 0]) = [Φ, Γ_1, Γ_2; ...]`, where `Γ_1 = ∫_0^T exp(A τ) dτ B` and
/// `Γ_2 = ∫_0^T exp(A (T - τ)) τ/T dτ B`. A held input has `Γ_now = Γ_1`, a linear one `Γ_now = Γ_1 - Γ_2`,
/// `Γ_next = Γ_2`.
///
/// The derivative of a linear input is constant over the tick: declare it as [`InputHold::Held`].
pub fn exact_step(system: &StateSpace<Continuous>, tick_s: f64, holds: &[InputHold]) -> Result<ExactStep, Error> {
    let tick_s = Discrete::new(tick_s)?.tick_s();
    let (n, m) = (system.states(), system.inputs());
    check_size("the number of holds", m, holds.len())?;
    let mut augmented = DMatrix::zeros(n + 2 * m, n + 2 * m);
    augmented.view_mut((0, 0), (n, n)).copy_from(&(system.a() * tick_s));
    augmented.view_mut((0, n), (n, m)).copy_from(&(system.b() * tick_s));
    augmented.view_mut((n, n + m), (m, m)).fill_with_identity();
    let whole = exponential(&augmented)?;

    let mut gamma_now = whole.view((0, n), (n, m)).into_owned();
    let mut gamma_next = DMatrix::zeros(n, m);
    for (j, _) in holds.iter().enumerate().filter(|(_, hold)| **hold == InputHold::Linear) {
        let ramp = whole.view((0, n + m + j), (n, 1));
        gamma_next.column_mut(j).copy_from(&ramp);
        let mut now = gamma_now.column_mut(j);
        now -= ramp;
    }
    Ok(ExactStep { phi: whole.view((0, 0), (n, n)).into_owned(), gamma_now, gamma_next })
}

/// `(exp(A T), Γ_1, C, D)`, between a hold and a sampler.
pub fn zero_order_hold(system: &StateSpace<Continuous>, tick_s: f64) -> Result<StateSpace<Discrete>, Error> {
    let step = exact_step(system, tick_s, &vec![InputHold::Held; system.inputs()])?;
    StateSpace::discrete(step.phi, step.gamma_now, system.c().clone(), system.d().clone(), tick_s)
}

/// Inverts [`zero_order_hold`] by `[A, B; 0, 0] T = log [Φ, Γ; 0, I]`; modes above the Nyquist frequency become their
/// slower alias.
pub fn undo_zero_order_hold(system: &StateSpace<Discrete>) -> Result<StateSpace<Continuous>, Error> {
    let (n, m) = (system.states(), system.inputs());
    let phi_log = logarithm(system.a())?;
    let mut block = DMatrix::identity(n + m, n + m);
    block.view_mut((0, 0), (n, n)).copy_from(system.a());
    block.view_mut((0, n), (n, m)).copy_from(system.b());
    let whole = logarithm(&block)?;
    let a = phi_log / system.tick_s();
    let b = whole.view((0, n), (n, m)) / system.tick_s();
    StateSpace::continuous(a, b, system.c().clone(), system.d().clone())
}

#[cfg(test)]
mod tests {
    use nalgebra::{dmatrix, dvector};

    use super::*;
    use crate::linear_algebra::product;

    /// `x' = -x + u`, and a second input through an integrator.
    fn plant() -> StateSpace<Continuous> {
        StateSpace::continuous(
            dmatrix![-1.0, 0.0; 0.0, 0.0],
            DMatrix::identity(2, 2),
            DMatrix::identity(2, 2),
            DMatrix::zeros(2, 2),
        )
        .expect("well formed")
    }

    /// `A Γ_1 = (Φ - I) B`, from the integral that defines Γ_1.
    fn gamma_one_residual(system: &StateSpace<Continuous>, step: &ExactStep) -> f64 {
        let n = system.states();
        let left = product(system.a(), &(&step.gamma_now + &step.gamma_next));
        let right = product(&(&step.phi - DMatrix::identity(n, n)), system.b());
        (left - right).amax()
    }

    #[test]
    fn each_input_has_a_separate_hold() {
        let step = exact_step(&plant(), 0.5, &[InputHold::Held, InputHold::Linear]).expect("finite");
        assert!((step.gamma_now[(0, 0)] - (1.0 - f64::exp(-0.5))).abs() < 1e-15);
        assert_eq!(step.gamma_next.column(0), dvector![0.0, 0.0]);
        // The integral of a linear input is the area of a trapezium.
        assert!((step.gamma_now[(1, 1)] - 0.25).abs() < 1e-16);
        assert!((step.gamma_next[(1, 1)] - 0.25).abs() < 1e-16);
        assert!(gamma_one_residual(&plant(), &step) < 1e-15);
    }

    #[test]
    fn a_wrong_number_of_holds_is_rejected() {
        let one_hold = exact_step(&plant(), 0.5, &[InputHold::Held]);
        assert_eq!(one_hold, Err(Error::DimensionMismatch { what: "the number of holds", expected: 2, found: 1 }));
        assert!(matches!(exact_step(&plant(), f64::NAN, &[]), Err(Error::TickNotPositive { .. })));
    }

    #[test]
    fn a_delay_is_not_the_hold_of_a_continuous_system() {
        let delay = StateSpace::discrete(dmatrix![0.0], dmatrix![1.0], dmatrix![1.0], dmatrix![0.0], 1e-3);
        assert!(matches!(
            undo_zero_order_hold(&delay.expect("well formed")),
            Err(Error::NoRealLogarithm { re: 0.0, .. })
        ));
    }
}
