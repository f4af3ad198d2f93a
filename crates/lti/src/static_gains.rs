use nalgebra::DMatrix;

use super::linear_algebra::{check_finite, check_size, product, solve};
use super::{Domain, Error, StateSpace};

/// Closes `u = K [y; r]`, `z = S [y; r]` around p outputs y and q external inputs r.
///
/// With `gain` `K = [K_y K_r]`, m x (p + q), `selection` `S = [S_y S_r]` and `E = (I - D K_y)⁻¹` of the algebraic loop:
/// `x' = (A + B K_y E C) x + B (K_y E D K_r + K_r) r`, `z = S_y E C x + (S_y E D K_r + S_r) r`.
pub fn connect<D: Domain>(
    system: &StateSpace<D>,
    gain: &DMatrix<f64>,
    selection: &DMatrix<f64>,
) -> Result<StateSpace<D>, Error> {
    let (m, p) = (system.inputs(), system.outputs());
    check_size("the number of rows of the gain", m, gain.nrows())?;
    check_size("the number of columns of the selection", gain.ncols(), selection.ncols())?;
    let Some(q) = gain.ncols().checked_sub(p) else {
        return Err(Error::DimensionMismatch {
            what: "the number of columns of the gain (outputs, then external inputs)",
            expected: p,
            found: gain.ncols(),
        });
    };
    check_finite("the gain", gain.as_slice())?;
    check_finite("the selection", selection.as_slice())?;
    let split = |k: &DMatrix<f64>| (k.columns(0, p).into_owned(), k.columns(p, q).into_owned());
    let (gain_y, gain_r) = split(gain);
    let (selection_y, selection_r) = split(selection);

    let singular = || Error::AlgebraicLoop { size: p };
    let open = DMatrix::identity(p, p) - product(system.d(), &gain_y);
    let y_x = solve(&open, system.c()).ok_or_else(singular)?;
    let y_r = solve(&open, &product(system.d(), &gain_r)).ok_or_else(singular)?;
    let u_x = product(&gain_y, &y_x);
    let u_r = product(&gain_y, &y_r) + gain_r;
    StateSpace::new(
        system.a() + product(system.b(), &u_x),
        product(system.b(), &u_r),
        product(&selection_y, &y_x),
        product(&selection_y, &y_r) + selection_r,
        system.domain(),
    )
}
