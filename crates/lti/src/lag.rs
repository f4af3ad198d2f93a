use nalgebra::{DMatrix, DVector};

use super::linear_algebra::{one_norm, product, solve};
use super::{Continuous, Error, InputHold, StateSpace, exact_step, exponential};

/// An input that moves over a tick from its actual value `u_0` towards a held command `c`:
///
/// ```text
/// u(t)    = c + (u_0 - c) exp(-t/τ)
/// x_{k+1} = Φ x_k + from_actual · u_0 + from_command · c
/// u_0     ← kept · u_0 + gained · c
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct LaggedInput {
    /// `∫_0^T exp(A (T-s)) B exp(-s/τ) ds`, n.
    pub from_actual: DVector<f64>,
    /// `∫_0^T exp(A (T-s)) B (1 - exp(-s/τ)) ds`, n.
    pub from_command: DVector<f64>,
    /// `exp(-T/τ)`, 0 without a lag.
    pub kept: f64,
    /// `1 - exp(-T/τ)`, 1 without a lag.
    pub gained: f64,
}

/// A lag of 0 gives [`exact_step`]'s held input, bit for bit. Otherwise one exponential gives both integrals, without
/// cancellation for a long lag:
///
/// `exp([A, B, 0; 0, -1/τ, 1/τ; 0, 0, 0] T) = [Φ, from_actual, from_command; ...]`
///
/// For a fast lag its squarings would lose Φ's digits; with `τ |A| <= 1/2` the well-conditioned
/// `(I + τ A) from_actual = τ (Φ - exp(-T/τ) I) B` replaces it.
pub fn lagged_input(
    system: &StateSpace<Continuous>,
    input: usize,
    tick_s: f64,
    lag_s: f64,
) -> Result<LaggedInput, Error> {
    let (n, count) = (system.states(), system.inputs());
    if input >= count {
        return Err(Error::IndexOutOfRange { what: "input", index: input, count });
    }
    if !(lag_s.is_finite() && lag_s >= 0.0) {
        return Err(Error::LagNegative { lag_s });
    }
    let step = exact_step(system, tick_s, &vec![InputHold::Held; count])?;
    let held = step.gamma_now.column(input).into_owned();
    if lag_s == 0.0 {
        return Ok(LaggedInput { from_actual: DVector::zeros(n), from_command: held, kept: 0.0, gained: 1.0 });
    }
    let b = system.b().columns(input, 1).into_owned();
    let time_constants = tick_s / lag_s;
    let (kept, gained) = (libm::exp(-time_constants), -libm::expm1(-time_constants));
    if time_constants >= 1.0 && 2.0 * lag_s * one_norm(system.a()) <= 1.0 {
        let left = DMatrix::identity(n, n) + system.a() * lag_s;
        let right = product(&(step.phi - DMatrix::identity(n, n) * kept), &b) * lag_s;
        let singular = Error::Singular { what: "I + τ A", size: n };
        let from_actual = solve(&left, &right).ok_or(singular)?.column(0).into_owned();
        return Ok(LaggedInput { from_command: held - &from_actual, from_actual, kept, gained });
    }
    let mut augmented = DMatrix::zeros(n + 2, n + 2);
    augmented.view_mut((0, 0), (n, n)).copy_from(&(system.a() * tick_s));
    augmented.view_mut((0, n), (n, 1)).copy_from(&(b * tick_s));
    augmented[(n, n)] = -time_constants;
    augmented[(n, n + 1)] = time_constants;
    let whole = exponential(&augmented)?;
    let column = |j: usize| whole.view((0, j), (n, 1)).column(0).into_owned();
    Ok(LaggedInput { from_actual: column(n), from_command: column(n + 1), kept, gained })
}

#[cfg(test)]
mod tests {
    use nalgebra::dmatrix;

    use super::*;

    const TICK_S: f64 = 1e-3;

    fn system(a: DMatrix<f64>, b: DMatrix<f64>) -> StateSpace<Continuous> {
        let (n, m) = b.shape();
        StateSpace::continuous(a, b, DMatrix::identity(n, n), DMatrix::zeros(n, m)).expect("well formed")
    }

    /// `Σ_{k≥0} (-r)^k / (k + order)!` gives every integral over a short part of a lag without cancellation.
    fn tail(r: f64, order: u32) -> f64 {
        let first = (1..=order).fold(1.0, |product, k| product / f64::from(k));
        let terms = (1..30).scan(first, |term, k| {
            *term *= -r / f64::from(order + k);
            Some(*term)
        });
        terms.fold(first, |sum, term| sum + term)
    }

    /// Position and velocity of a mass after a tick from rest, integrated by hand.
    fn mass(lag_s: f64) -> [[f64; 2]; 2] {
        let r = TICK_S / lag_s;
        if r < 1.0 {
            let (position, velocity) = (TICK_S * TICK_S, TICK_S);
            return [
                [position * tail(r, 2), velocity * tail(r, 1)],
                [position * r * tail(r, 3), velocity * r * tail(r, 2)],
            ];
        }
        let velocity = lag_s * (1.0 - (-r).exp());
        let position = lag_s * (TICK_S - velocity);
        [[position, velocity], [TICK_S * TICK_S / 2.0 - position, TICK_S - velocity]]
    }

    #[test]
    fn a_mass_moves_as_integrated_by_hand_for_any_lag() {
        let mass_alone = system(dmatrix![0.0, 1.0; 0.0, 0.0], dmatrix![0.0; 1.0]);
        for power in -15..=12 {
            for factor in [1.0, 3.3] {
                let lag_s = factor * 10f64.powi(power);
                let step = lagged_input(&mass_alone, 0, TICK_S, lag_s).expect("finite");
                for (found, expected) in [&step.from_actual, &step.from_command].into_iter().zip(mass(lag_s)) {
                    for i in 0..2 {
                        let error = (found[i] / expected[i] - 1.0).abs();
                        assert!(error < 1e-12, "{lag_s:e} {i}: {error:e}");
                    }
                }
            }
        }
    }

    #[test]
    fn a_system_pole_equal_to_the_lags_pole_is_handled() {
        for lag_s in [1e-5, 2e-4, 1e-3, 0.3] {
            let twin = system(dmatrix![-1.0 / lag_s], dmatrix![1.0]);
            let step = lagged_input(&twin, 0, TICK_S, lag_s).expect("finite");
            let expected = TICK_S * (-TICK_S / lag_s).exp();
            assert!((step.from_actual[0] - expected).abs() < 1e-12 * expected, "{lag_s}");
        }
    }

    #[test]
    fn both_formulas_agree_at_their_boundary() {
        let a = dmatrix![0.0, 1.0, 0.0; -8000.0, -100.0, 30.0; 500.0, 0.0, -900.0];
        let meeting_s = 1.0 / (2.0 * one_norm(&a));
        let oscillator = system(a, dmatrix![0.0; 1.0; 2.0]);
        let step = |lag_s| lagged_input(&oscillator, 0, TICK_S, lag_s).expect("finite");
        let (solved, augmented) = (step(meeting_s), step(meeting_s * (1.0 + 4e-16)));
        for (a, b) in [(&solved.from_actual, &augmented.from_actual), (&solved.from_command, &augmented.from_command)] {
            for i in 0..3 {
                assert!((a[i] - b[i]).abs() < 1e-12 * a[i].abs(), "{i}: {} {}", a[i], b[i]);
            }
        }
    }

    #[test]
    fn a_zero_lag_is_a_held_input_and_invalid_times_are_rejected() {
        let plant = system(dmatrix![-3.0, 1.0; 0.0, -40.0], dmatrix![1.0, 0.0; 0.5, 2.0]);
        let held = exact_step(&plant, TICK_S, &[InputHold::Held; 2]).expect("finite");
        let step = lagged_input(&plant, 1, TICK_S, 0.0).expect("finite");
        assert_eq!(step.from_command, held.gamma_now.column(1));
        assert_eq!((step.from_actual.amax(), step.kept, step.gained), (0.0, 0.0, 1.0));
        for lag_s in [-1e-3, f64::NAN, f64::INFINITY] {
            assert!(matches!(lagged_input(&plant, 0, TICK_S, lag_s), Err(Error::LagNegative { .. })));
        }
        assert!(matches!(lagged_input(&plant, 2, TICK_S, 0.0), Err(Error::IndexOutOfRange { .. })));
    }
}
