use nalgebra::DMatrix;

use super::linear_algebra::{check_finite, product};
use super::{Continuous, Domain, Error, StateSpace, TransferFunction};

/// Controllable canonical form (Kailath, *Linear Systems*, 2.1); common factors are kept.
///
/// With monic D(s) of degree n, the states are w, w', ..., w^(n-1) of `D(d/dt) w = u`, and `y = N(d/dt) w`.
pub fn realise(function: &TransferFunction) -> Result<StateSpace<Continuous>, Error> {
    check_finite("the numerator", function.numerator().coefficients())?;
    check_finite("the denominator", function.denominator().coefficients())?;
    let n = function.denominator().degree().ok_or(Error::ZeroDenominator)?;
    let numerator_degree = function.numerator().degree().unwrap_or(0);
    if numerator_degree > n {
        return Err(Error::Improper { numerator_degree, denominator_degree: n });
    }
    let leading = function.denominator().coefficient(n);
    let below = |power| function.denominator().coefficient(power) / leading;
    let above = |power| function.numerator().coefficient(power) / leading;

    let a = DMatrix::from_fn(n, n, |i, j| {
        if i + 1 == n {
            -below(j)
        } else if i + 1 == j {
            1.0
        } else {
            0.0
        }
    });
    let b = DMatrix::from_fn(n, 1, |i, _| if i + 1 == n { 1.0 } else { 0.0 });
    let direct = above(n);
    let c = DMatrix::from_fn(1, n, |_, j| above(j) - direct * below(j));
    StateSpace::continuous(a, b, c, DMatrix::from_element(1, 1, direct))
}

/// The outputs y and y' are also the first two states.
///
/// `y' = C A x + C B u` requires `C B = 0`: a relative degree of at least 2.
pub fn realise_with_derivative(function: &TransferFunction) -> Result<StateSpace<Continuous>, Error> {
    let found = function.relative_degree().ok_or(Error::ZeroTransferFunction)?;
    if found < 2 {
        return Err(Error::RelativeDegreeTooLow { needed: 2, found });
    }
    let single = realise(function)?;
    let n = single.states();
    let mut c = DMatrix::zeros(2, n);
    c.row_mut(0).copy_from(&single.c().row(0));
    c.row_mut(1).copy_from(&product(single.c(), single.a()).row(0));
    let both = StateSpace::continuous(single.a().clone(), single.b().clone(), c, DMatrix::zeros(2, 1))?;
    outputs_first(&both, &[0, 1])
}

/// The chosen outputs become the first states, with exact unit vectors in C.
///
/// `z = T x`: the chosen rows of C, completed by the old states for which T is best conditioned.
pub fn outputs_first<D: Domain>(system: &StateSpace<D>, outputs: &[usize]) -> Result<StateSpace<D>, Error> {
    let n = system.states();
    let refuse = |reason| Err(Error::OutputsNotStates { outputs: outputs.len(), reason });
    for &index in outputs {
        if index >= system.outputs() {
            return Err(Error::IndexOutOfRange { what: "output", index, count: system.outputs() });
        }
        if system.d().row(index).iter().any(|v| *v != 0.0) {
            return refuse("one of them has a direct path from an input");
        }
    }
    if outputs.len() > n {
        return refuse("there are fewer states");
    }
    let mut t = DMatrix::zeros(n, n);
    // Gaussian elimination finds the old states to replace.
    let mut reduced = DMatrix::from_fn(outputs.len(), n, |i, j| system.c()[(outputs[i], j)]);
    let mut replaced = vec![false; n];
    for (row, &output) in outputs.iter().enumerate() {
        t.row_mut(row).copy_from(&system.c().row(output));
        let before = system.c().row(output).amax();
        let pivot = (0..n)
            .filter(|j| !replaced[*j])
            .max_by(|a, b| reduced[(row, *a)].abs().total_cmp(&reduced[(row, *b)].abs()).then(b.cmp(a)));
        let Some(pivot) = pivot.filter(|j| reduced[(row, *j)].abs() > n as f64 * f64::EPSILON * before) else {
            return refuse("they are not independent combinations of the states");
        };
        replaced[pivot] = true;
        for below in row + 1..outputs.len() {
            let factor = reduced[(below, pivot)] / reduced[(row, pivot)];
            for j in 0..n {
                let carried = factor * reduced[(row, j)];
                reduced[(below, j)] -= carried;
            }
            reduced[(below, pivot)] = 0.0;
        }
    }
    let kept = (0..n).filter(|j| !replaced[*j]);
    for (row, state) in (outputs.len()..n).zip(kept) {
        t[(row, state)] = 1.0;
    }
    let moved = system.transform(&t)?;
    let mut c = moved.c().clone();
    for (state, &output) in outputs.iter().enumerate() {
        c.row_mut(output).fill(0.0);
        c[(output, state)] = 1.0;
    }
    StateSpace::new(moved.a().clone(), moved.b().clone(), c, moved.d().clone(), moved.domain())
}

#[cfg(test)]
mod tests {
    use nalgebra::dmatrix;

    use super::*;
    use crate::Complex64;

    #[test]
    fn an_improper_function_is_rejected_with_its_degrees() {
        let improper = TransferFunction::new(&[1.0, 0.0, 0.0], &[1.0, 1.0]).expect("well formed");
        assert_eq!(realise(&improper), Err(Error::Improper { numerator_degree: 2, denominator_degree: 1 }));
    }

    #[test]
    fn a_biproper_function_keeps_its_direct_path() {
        let function = TransferFunction::new(&[4.0, 1.0], &[2.0, 6.0]).expect("well formed");
        let system = realise(&function).expect("proper");
        assert_eq!(system.d(), &dmatrix![2.0]);
        let s = Complex64::new(0.3, 1.7);
        assert!((system.evaluate(s).expect("regular")[(0, 0)] - function.evaluate(s)).norm() < 1e-15);
    }

    #[test]
    fn the_master_has_position_and_velocity_as_states() {
        let master = TransferFunction::new(&[1.0], &[0.245, 4.1, 0.0]).expect("well formed");
        let system = realise_with_derivative(&master).expect("relative degree 2");
        assert_eq!(system.c(), &DMatrix::identity(2, 2));
        assert!((system.a() - dmatrix![0.0, 1.0; 0.0, -4.1 / 0.245]).amax() < 1e-14);
        assert!((system.b() - dmatrix![0.0; 1.0 / 0.245]).amax() < 1e-14);
    }

    #[test]
    fn the_slave_has_position_and_velocity_among_three_states() {
        let slave = TransferFunction::new(&[7.778, 656.0], &[1.0, 104.1, 1.131e-4, 0.0]).expect("well formed");
        let system = realise_with_derivative(&slave).expect("relative degree 2");
        assert!((system.a().row(0) - dmatrix![0.0, 1.0, 0.0]).amax() < 1e-12);
        let s = Complex64::new(-3.0, 40.0);
        let h = system.evaluate(s).expect("regular");
        assert!((h[(0, 0)] / slave.evaluate(s) - 1.0).norm() < 1e-12);
        assert!((h[(1, 0)] / (slave.evaluate(s) * s) - 1.0).norm() < 1e-12);
    }

    #[test]
    fn a_lag_has_no_velocity_without_a_direct_path() {
        let lag = TransferFunction::new(&[1.0], &[1.0, 1.0]).expect("well formed");
        assert_eq!(realise_with_derivative(&lag), Err(Error::RelativeDegreeTooLow { needed: 2, found: 1 }));
    }

    #[test]
    fn dependent_outputs_cannot_both_be_states() {
        let twice = StateSpace::continuous(
            dmatrix![0.0, 1.0; 0.0, 0.0],
            dmatrix![0.0; 1.0],
            dmatrix![1.0, 1.0; 2.0, 2.0],
            dmatrix![0.0; 0.0],
        );
        assert!(matches!(
            outputs_first(&twice.expect("well formed"), &[0, 1]),
            Err(Error::OutputsNotStates { outputs: 2, .. })
        ));
    }
}
