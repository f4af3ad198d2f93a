use nalgebra::DMatrix;

use super::linear_algebra::check_size;
use super::{Domain, Error, Interconnection, Signal, StateSpace};

/// Block-diagonal, in the order of `systems`.
pub fn append<D: Domain>(systems: &[&StateSpace<D>]) -> Result<StateSpace<D>, Error> {
    let Some((first, rest)) = systems.split_first() else {
        return Err(Error::DimensionMismatch { what: "the number of systems to append", expected: 1, found: 0 });
    };
    let domain = rest.iter().try_fold(first.domain(), |domain, next| domain.shared_with(next.domain()))?;
    let diagonal = |block: fn(&StateSpace<D>) -> &DMatrix<f64>| {
        let rows = systems.iter().map(|s| block(s).nrows()).sum();
        let columns = systems.iter().map(|s| block(s).ncols()).sum();
        let mut whole = DMatrix::zeros(rows, columns);
        let (mut row, mut column) = (0, 0);
        for system in systems {
            let part = block(system);
            whole.view_mut((row, column), part.shape()).copy_from(part);
            row += part.nrows();
            column += part.ncols();
        }
        whole
    };
    StateSpace::new(
        diagonal(StateSpace::a),
        diagonal(StateSpace::b),
        diagonal(StateSpace::c),
        diagonal(StateSpace::d),
        domain,
    )
}

/// `y = H_2 H_1 u`; the states are first's, then second's.
pub fn series<D: Domain>(first: &StateSpace<D>, second: &StateSpace<D>) -> Result<StateSpace<D>, Error> {
    check_size("the number of inputs of the second system", first.outputs(), second.inputs())?;
    let both = append(&[first, second])?;
    let mut wiring = Interconnection::new(&both, first.inputs());
    for i in 0..first.inputs() {
        wiring = wiring.feed(i, &[(1.0, Signal::External(i))])?;
    }
    for i in 0..second.inputs() {
        wiring = wiring.feed(first.inputs() + i, &[(1.0, Signal::Output(i))])?;
    }
    for i in 0..second.outputs() {
        wiring = wiring.read(&[(1.0, Signal::Output(first.outputs() + i))])?;
    }
    wiring.close(&both)
}

/// `y = (H_1 + H_2) u`.
pub fn parallel<D: Domain>(first: &StateSpace<D>, second: &StateSpace<D>) -> Result<StateSpace<D>, Error> {
    check_size("the number of inputs of the second system", first.inputs(), second.inputs())?;
    check_size("the number of outputs of the second system", first.outputs(), second.outputs())?;
    let both = append(&[first, second])?;
    let mut wiring = Interconnection::new(&both, first.inputs());
    for i in 0..first.inputs() {
        wiring = wiring.feed(i, &[(1.0, Signal::External(i))])?;
        wiring = wiring.feed(first.inputs() + i, &[(1.0, Signal::External(i))])?;
    }
    for i in 0..first.outputs() {
        wiring = wiring.read(&[(1.0, Signal::Output(i)), (1.0, Signal::Output(first.outputs() + i))])?;
    }
    wiring.close(&both)
}

/// Negative feedback: `y = H_f (r - H_b y)`, so `(I + H_f H_b)⁻¹ H_f`.
pub fn feedback<D: Domain>(forward: &StateSpace<D>, back: &StateSpace<D>) -> Result<StateSpace<D>, Error> {
    check_size("the number of inputs of the feedback", forward.outputs(), back.inputs())?;
    check_size("the number of outputs of the feedback", forward.inputs(), back.outputs())?;
    let both = append(&[forward, back])?;
    let mut wiring = Interconnection::new(&both, forward.inputs());
    for i in 0..forward.inputs() {
        let error = [(1.0, Signal::External(i)), (-1.0, Signal::Output(forward.outputs() + i))];
        wiring = wiring.feed(i, &error)?;
    }
    for i in 0..forward.outputs() {
        wiring = wiring.feed(forward.inputs() + i, &[(1.0, Signal::Output(i))])?;
        wiring = wiring.read(&[(1.0, Signal::Output(i))])?;
    }
    wiring.close(&both)
}

#[cfg(test)]
mod tests {
    use nalgebra::dmatrix;

    use super::*;
    use crate::Continuous;

    #[test]
    fn a_loop_of_direct_paths_with_gain_one_is_rejected() {
        let forward = StateSpace::gain(dmatrix![2.0], Continuous).expect("finite");
        let back = StateSpace::gain(dmatrix![-0.5], Continuous).expect("finite");
        assert_eq!(feedback(&forward, &back), Err(Error::AlgebraicLoop { size: 2 }));
        let safe = feedback(&forward, &StateSpace::gain(dmatrix![0.5], Continuous).expect("finite"));
        assert_eq!(safe.expect("regular").d(), &dmatrix![1.0]);
    }

    #[test]
    fn systems_with_different_ticks_are_rejected() {
        let gain = |tick_s| {
            let zero = || dmatrix![0.0];
            StateSpace::discrete(zero(), zero(), zero(), zero(), tick_s).expect("well formed")
        };
        assert_eq!(parallel(&gain(1e-3), &gain(2e-3)), Err(Error::UnequalTicks { first_s: 1e-3, second_s: 2e-3 }));
        assert_eq!(series(&gain(1e-3), &gain(1e-3)).expect("same tick").tick_s(), 1e-3);
    }

    #[test]
    fn systems_of_different_sizes_are_rejected() {
        let one = StateSpace::gain(dmatrix![1.0], Continuous).expect("finite");
        let two = StateSpace::gain(dmatrix![1.0, 1.0], Continuous).expect("finite");
        assert!(matches!(series(&one, &two), Err(Error::DimensionMismatch { expected: 1, found: 2, .. })));
        assert!(append::<Continuous>(&[]).is_err());
        assert!(crate::connect(&one, &DMatrix::zeros(1, 0), &DMatrix::zeros(1, 0)).is_err());
    }
}
