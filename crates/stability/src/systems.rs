use nalgebra::{DMatrix, DVector};

use super::{ClosedLoop, LinearLoop, Parameter, StabilityError};
use trocar_lti::{Complex64, Discrete, StateSpace, StepResponse, eigenvalues, step_response_discrete};

const MAX_STATES: u64 = 400;

/// Relative; a smaller column or row counts as 0.
const VANISHING: f64 = 1e-11;

#[derive(Debug, Clone)]
pub struct LoopSystem {
    pub system: StateSpace<Discrete>,
    pub inputs: Vec<&'static str>,
    pub outputs: Vec<&'static str>,
}

#[derive(Debug, Clone, PartialEq)]
pub struct PolesAndZeros {
    pub system: &'static str,
    /// In the z plane, largest modulus first.
    pub poles: Vec<Complex64>,
    pub zeros: Vec<Complex64>,
}

#[derive(Debug, Clone, PartialEq)]
pub struct Locus {
    pub parameter: Parameter,
    pub branches: Vec<(f64, Vec<Complex64>)>,
}

fn sorted(mut values: Vec<Complex64>) -> Vec<Complex64> {
    values.sort_by(|a, b| (b.norm(), b.im).partial_cmp(&(a.norm(), a.im)).unwrap_or(std::cmp::Ordering::Equal));
    values
}

/// Of `c (z I - A)^-1 b + d`: for nonzero `d` the eigenvalues of `A - b c / d`. Otherwise let `c A^(r-1) b` be the
/// first nonzero Markov parameter: the eigenvalues of `A - b (c A^r) / (c A^(r-1) b)` without `r` that are 0.
fn zeros(a: &DMatrix<f64>, b: &DVector<f64>, c: &DVector<f64>, d: f64) -> Result<Vec<Complex64>, StabilityError> {
    let n = a.nrows();
    if d != 0.0 {
        return Ok(eigenvalues(&(a - b * c.transpose() / d))?);
    }
    let mut row = c.clone();
    for delay in 1..=n {
        let first = row.dot(b);
        let size = row.norm() * b.norm();
        let next = a.tr_mul(&row);
        if first.abs() > VANISHING * size {
            let mut values = eigenvalues(&(a - b * next.transpose() / first))?;
            values.sort_by(|x, y| y.norm().total_cmp(&x.norm()));
            values.truncate(n - delay);
            return Ok(values);
        }
        row = next;
    }
    Ok(vec![])
}

impl LoopSystem {
    pub fn poles_and_zeros(&self, name: &'static str, output: usize) -> Result<PolesAndZeros, StabilityError> {
        let system = &self.system;
        let (b, c) = (system.b().column(0).into_owned(), system.c().row(output).transpose());
        Ok(PolesAndZeros {
            system: name,
            poles: sorted(system.poles()?),
            zeros: sorted(zeros(system.a(), &b, &c, system.d()[(output, 0)])?),
        })
    }

    pub fn step(&self, samples: usize) -> Result<StepResponse, StabilityError> {
        Ok(step_response_discrete(&self.system, 0, samples)?)
    }
}

impl ClosedLoop {
    fn domain(&self) -> Result<Discrete, StabilityError> {
        Ok(Discrete::new(self.tick_s())?)
    }

    /// With the sign of `L`; negative feedback has `-L`.
    pub fn loop_gain_system(&self) -> Result<LoopSystem, StabilityError> {
        let (a, b, c) = self.open()?;
        let b = DMatrix::from_column_slice(b.len(), 1, b.as_slice());
        let c = DMatrix::from_row_slice(1, c.len(), c.as_slice());
        let system = StateSpace::new(a, b, c, DMatrix::zeros(1, 1), self.domain()?)?;
        Ok(LoopSystem { system, inputs: vec!["arriving_force_n"], outputs: vec!["returning_force_n"] })
    }

    /// From the desired position, linear between ticks, to positions and feedback force.
    ///
    /// The state includes the desired position of the next tick, `x = x' + b_next u`, so
    /// `x'+ = A x' + (A b_next + b_now) u`.
    pub fn closed_loop_system(&self) -> Result<LoopSystem, StabilityError> {
        let (a, [now, next], at_slave) = self.matrix()?;
        let (_, _, arrives) = self.open()?;
        let n = a.nrows();
        let mut rows = DMatrix::zeros(3, n);
        rows[(0, 0)] = 1.0;
        rows[(1, at_slave)] = 1.0;
        let local = &self.master.local;
        let force = DVector::from_fn(n, |k, _| arrives[k] + local.get(k).copied().unwrap_or(0.0));
        rows.row_mut(2).copy_from(&force.transpose());
        let b = &a * &next + now;
        let d = &rows * &next;
        let b = DMatrix::from_column_slice(n, 1, b.as_slice());
        let d = DMatrix::from_column_slice(3, 1, d.as_slice());
        Ok(LoopSystem {
            system: StateSpace::new(a, b, rows, d, self.domain()?)?,
            inputs: vec!["desired_position_m"],
            outputs: vec!["master_position_m", "slave_position_m", "feedback_force_n"],
        })
    }

    /// Empty if a long delay needs too many states.
    pub fn poles_and_zeros(&self) -> Result<Vec<PolesAndZeros>, StabilityError> {
        if self.states() > MAX_STATES {
            return Ok(vec![]);
        }
        Ok(vec![
            self.closed_loop_system()?.poles_and_zeros("closed loop", 2)?,
            self.loop_gain_system()?.poles_and_zeros("loop gain", 0)?,
        ])
    }
}

impl Locus {
    pub fn of(settings: &LinearLoop, axis: &super::Axis) -> Result<Self, StabilityError> {
        let at = |index: usize| -> Result<(f64, Vec<Complex64>), StabilityError> {
            let value = axis.value(index);
            let closed = ClosedLoop::new(&settings.with(axis.parameter, value))?;
            Ok((value, sorted(eigenvalues(&closed.matrix()?.0)?)))
        };
        let branches = (0..axis.count).map(at).collect::<Result<_, _>>()?;
        Ok(Self { parameter: axis.parameter, branches })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn zeros_agree_with_the_polynomials() {
        // (z - 0.5) / ((z - 0.9) (z - 0.2)), then with one more tick of delay.
        let a = DMatrix::from_row_slice(2, 2, &[1.1, -0.18, 1.0, 0.0]);
        let (b, c) = (DVector::from_column_slice(&[1.0, 0.0]), DVector::from_column_slice(&[1.0, -0.5]));
        let found = zeros(&a, &b, &c, 0.0).expect("computed");
        assert!(found.len() == 1 && (found[0] - Complex64::new(0.5, 0.0)).norm() < 1e-12);
        let mut late = DMatrix::zeros(3, 3);
        late.view_mut((0, 0), (2, 2)).copy_from(&a);
        late.view_mut((2, 0), (1, 2)).copy_from(&c.transpose());
        let (b, c) = (DVector::from_column_slice(&[1.0, 0.0, 0.0]), DVector::from_column_slice(&[0.0, 0.0, 1.0]));
        let found = zeros(&late, &b, &c, 0.0).expect("computed");
        assert!(found.len() == 1 && (found[0] - Complex64::new(0.5, 0.0)).norm() < 1e-12);
        // With feedthrough, 1 + (z - 0.5) / ... has two zeros.
        let found = zeros(&a, &DVector::from_column_slice(&[1.0, 0.0]), &DVector::from_column_slice(&[1.0, -0.5]), 1.0);
        assert_eq!(found.expect("computed").len(), 2);
    }
}
