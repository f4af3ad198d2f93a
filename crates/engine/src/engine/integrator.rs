use std::ops::Mul;

use nalgebra::allocator::Allocator;
use nalgebra::{DefaultAllocator, Dim, OVector};
use ode_solvers::dop_shared::OutputType;
use ode_solvers::{Dop853, System};

pub use ode_solvers::dop_shared::IntegrationError as Failure;

use super::Differential;

const RELATIVE_TOLERANCE: f64 = 1e-12;
const ABSOLUTE_TOLERANCE: f64 = 1e-14;

struct Solved<E>(E);

impl<E: Differential<V>, V> System<f64, V> for Solved<E> {
    fn system(&self, _time: f64, state: &V, derivative: &mut V) {
        self.0.system(state, derivative);
    }
}

pub(super) fn integrate<D: Dim>(
    equations: impl Differential<OVector<f64, D>>,
    duration_s: f64,
    state: &mut OVector<f64, D>,
) -> Result<(), Failure>
where
    DefaultAllocator: Allocator<D>,
    OVector<f64, D>: Mul<f64, Output = OVector<f64, D>>,
{
    let (start, end_s) = (state.clone(), duration_s);
    let mut solver = Dop853::new(Solved(equations), 0.0, end_s, end_s, start, RELATIVE_TOLERANCE, ABSOLUTE_TOLERANCE);
    solver.set_output(OutputType::Sparse);
    solver.integrate()?;
    if let Some(last) = solver.y_out().last() {
        state.clone_from(last);
    }
    Ok(())
}
