use nalgebra::DMatrix;

use super::linear_algebra::{product, solve, solve_right};
use super::{Continuous, Discrete, Error, StateSpace};

/// `s = α (z - 1)/(z + 1)` with `α = 2/T`, or `ω / tan(ω T / 2)`: exact at ω (rad/s).
///
/// With `P = (α I - A)⁻¹`: `A_d = P (α I + A)`, `B_d = √(2α) P B`, `C_d = √(2α) C P`, `D_d = D + C P B`. Stable systems
/// remain stable; a pole at `s = α` has no image.
pub fn tustin(
    system: &StateSpace<Continuous>,
    tick_s: f64,
    prewarp_rad_per_s: Option<f64>,
) -> Result<StateSpace<Discrete>, Error> {
    let n = system.states();
    let alpha = warp(Discrete::new(tick_s)?, prewarp_rad_per_s)?;
    let singular = || Error::Singular { what: "α I - A", size: n };
    let diagonal = DMatrix::identity(n, n) * alpha;
    let minus = &diagonal - system.a();
    let a = solve(&minus, &(&diagonal + system.a())).ok_or_else(singular)?;
    let p_b = solve(&minus, system.b()).ok_or_else(singular)?;
    let c_p = solve_right(&minus, system.c()).ok_or_else(singular)?;
    let d = system.d() + product(system.c(), &p_b);
    let root = (2.0 * alpha).sqrt();
    StateSpace::discrete(a, p_b * root, c_p * root, d, tick_s)
}

/// Inverts [`tustin`] with the same prewarping; a pole at `z = -1` has no image.
///
/// With `Q = (A_d + I)⁻¹`: `A = α Q (A_d - I)`, `B = √(2α) Q B_d`, `C = √(2α) C_d Q`, `D = D_d - C_d Q B_d`.
pub fn undo_tustin(
    system: &StateSpace<Discrete>,
    prewarp_rad_per_s: Option<f64>,
) -> Result<StateSpace<Continuous>, Error> {
    let n = system.states();
    let alpha = warp(system.domain(), prewarp_rad_per_s)?;
    let singular = || Error::Singular { what: "A + I (a pole at z = -1)", size: n };
    let identity = DMatrix::identity(n, n);
    let plus = system.a() + &identity;
    let a = solve(&plus, &(system.a() - &identity)).ok_or_else(singular)? * alpha;
    let q_b = solve(&plus, system.b()).ok_or_else(singular)?;
    let c_q = solve_right(&plus, system.c()).ok_or_else(singular)?;
    let d = system.d() - product(system.c(), &q_b);
    let root = (2.0 * alpha).sqrt();
    StateSpace::continuous(a, q_b * root, c_q * root, d)
}

fn warp(domain: Discrete, prewarp_rad_per_s: Option<f64>) -> Result<f64, Error> {
    let tick_s = domain.tick_s();
    let Some(rad_per_s) = prewarp_rad_per_s else {
        return Ok(2.0 / tick_s);
    };
    let nyquist_rad_per_s = std::f64::consts::PI / tick_s;
    if rad_per_s > 0.0 && rad_per_s < nyquist_rad_per_s {
        Ok(rad_per_s / libm::tan(0.5 * rad_per_s * tick_s))
    } else {
        Err(Error::PrewarpOutOfRange { rad_per_s, nyquist_rad_per_s })
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::dmatrix;

    use super::*;
    use crate::Domain;

    fn lag() -> StateSpace<Continuous> {
        StateSpace::continuous(dmatrix![-5.0], dmatrix![5.0], dmatrix![1.0], dmatrix![0.0]).expect("well formed")
    }

    #[test]
    fn a_lag_agrees_with_its_closed_form() {
        // 5/(s + 5) with s = 20 (z - 1)/(z + 1) is (z + 1)/(5 z - 3).
        let discrete = tustin(&lag(), 0.1, None).expect("regular");
        assert!((discrete.a()[(0, 0)] - 0.6).abs() < 1e-15);
        assert!((discrete.d()[(0, 0)] - 0.2).abs() < 1e-15);
        assert!((discrete.dc_gain().expect("finite")[(0, 0)] - 1.0).abs() < 1e-14);
    }

    #[test]
    fn prewarping_keeps_the_response_at_its_frequency() {
        let discrete = tustin(&lag(), 0.1, Some(12.0)).expect("regular");
        let at = |z| discrete.evaluate(z).expect("regular")[(0, 0)];
        let wanted = lag().evaluate(Continuous.frequency_point(12.0)).expect("regular")[(0, 0)];
        assert!((at(discrete.domain().frequency_point(12.0)) - wanted).norm() < 1e-14);
        let back = undo_tustin(&discrete, Some(12.0)).expect("regular");
        assert!((back.a() - lag().a()).amax() < 1e-13);
    }

    #[test]
    fn poles_without_an_image_are_rejected() {
        assert!(matches!(tustin(&lag(), 0.1, Some(40.0)), Err(Error::PrewarpOutOfRange { .. })));
        assert!(matches!(tustin(&lag(), 0.1, Some(f64::NAN)), Err(Error::PrewarpOutOfRange { .. })));
        let at_alpha = StateSpace::continuous(dmatrix![20.0], dmatrix![1.0], dmatrix![1.0], dmatrix![0.0]);
        assert!(matches!(tustin(&at_alpha.expect("well formed"), 0.1, None), Err(Error::Singular { .. })));
    }
}
