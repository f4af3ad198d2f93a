use nalgebra::DVector;

use super::integrator::integrate;
use super::{Differential, IntegrationError};
use crate::plant::{PlantError, SlaveModel, SlaveParameters};

const PARTS: usize = 10;

type State = DVector<f64>;

/// `x' = A x + b_u u + b_w w`, with A row by row, and the position `c x`.
#[derive(Debug, Clone)]
pub(super) struct Equations {
    a: Vec<Vec<f64>>,
    motor: Vec<f64>,
    external: Vec<f64>,
    position: Vec<f64>,
}

struct Driven<'a> {
    equations: &'a Equations,
    command: f64,
    external_n: f64,
}

impl Differential<State> for Driven<'_> {
    fn system(&self, state: &State, derivative: &mut State) {
        for i in 0..self.equations.states() {
            derivative[i] = self.equations.derivative(i, state.as_slice(), self.command, self.external_n);
        }
    }
}

#[derive(Debug, Clone)]
pub struct IntegratedSlave {
    equations: Equations,
    is_loaded: bool,
    constant_n: f64,
    friction_n: f64,
    part_s: f64,
    state: State,
}

impl IntegratedSlave {
    pub fn new(slave: &SlaveParameters, tick_s: f64, (position_m, command): (f64, f64)) -> Result<Self, PlantError> {
        let mut equations = match slave.model {
            SlaveModel::Appendix | SlaveModel::TransferFunction => {
                Equations::of_function(&slave.numerator, &slave.denominator)
            }
            SlaveModel::MassDamper => Equations::of_mass(slave.mass_kg, slave.damping_n_s_per_m),
            SlaveModel::StateSpace => Equations::of_matrices(&slave.a, &slave.b, &slave.c),
        };
        let is_general = slave.model != SlaveModel::Appendix;
        if !is_general {
            equations.external.fill(0.0);
        }
        let constant_n = if is_general { slave.constant_force_n } else { 0.0 };
        let state = match slave.model {
            SlaveModel::Appendix | SlaveModel::TransferFunction => {
                Some(equations.rest_of_function(position_m, [command, constant_n]))
            }
            SlaveModel::MassDamper => Some(State::from_vec(vec![position_m, 0.0])),
            SlaveModel::StateSpace => equations.rest_of_matrices(position_m, [command, constant_n]),
        };
        let state = state.ok_or(PlantError::NoRest { side: "slave", start_m: position_m })?;
        let friction_n = if slave.model == SlaveModel::MassDamper { slave.coulomb_friction_n } else { 0.0 };
        let (is_loaded, part_s) = (is_general && slave.load, tick_s / PARTS as f64);
        Ok(Self { equations, is_loaded, constant_n, friction_n, part_s, state })
    }

    pub fn output(&self) -> [f64; 2] {
        self.equations.output(self.state.as_slice())
    }

    pub fn advance(&mut self, command: f64, tissue_n: f64) -> Result<(), IntegrationError> {
        let external_n = if self.is_loaded { tissue_n + self.constant_n } else { self.constant_n };
        for _ in 0..PARTS {
            if self.friction_n == 0.0 {
                self.state = self.integrate(command, external_n)?;
                continue;
            }
            let force_n = command + external_n;
            let velocity = self.state[1];
            if velocity == 0.0 && force_n.abs() <= self.friction_n {
                continue;
            }
            let direction = if velocity == 0.0 { force_n.signum() } else { velocity.signum() };
            let after = self.integrate(command - direction * self.friction_n, external_n)?;
            let has_stopped = after[1] * direction <= 0.0;
            self.state = after;
            if has_stopped {
                self.state[1] = 0.0;
            }
        }
        Ok(())
    }

    fn integrate(&self, command: f64, external_n: f64) -> Result<State, IntegrationError> {
        let driven = Driven { equations: &self.equations, command, external_n };
        let mut state = self.state.clone();
        integrate(driven, self.part_s, &mut state)?;
        Ok(state)
    }
}

impl Equations {
    pub(super) fn of_mass(mass_kg: f64, damping_n_s_per_m: f64) -> Self {
        let by_mass = 1.0 / mass_kg;
        Self {
            a: vec![vec![0.0, 1.0], vec![0.0, -damping_n_s_per_m * by_mass]],
            motor: vec![0.0, by_mass],
            external: vec![0.0, by_mass],
            position: vec![1.0, 0.0],
        }
    }

    pub(super) fn of_matrices(a: &[f64], b: &[f64], c: &[f64]) -> Self {
        Self {
            a: a.chunks(c.len()).map(<[f64]>::to_vec).collect(),
            motor: b.iter().copied().step_by(2).collect(),
            external: b.iter().copied().skip(1).step_by(2).collect(),
            position: c.to_vec(),
        }
    }

    /// Observer form: `z_i' = z_{i+1} - a_i z_1 + b_i u`, with the position `z_1`.
    pub(super) fn of_function(numerator: &[f64], denominator: &[f64]) -> Self {
        let n = denominator.len() - 1;
        let leading = denominator[0];
        let above = |power: usize| numerator.iter().rev().nth(power).map_or(0.0, |value| value / leading);
        let a = (0..n)
            .map(|i| {
                let mut row = vec![0.0; n];
                row[0] = -denominator[i + 1] / leading;
                if i + 1 < n {
                    row[i + 1] = 1.0;
                }
                row
            })
            .collect();
        let motor: Vec<f64> = (0..n).map(|i| above(n - 1 - i)).collect();
        let mut position = vec![0.0; n];
        position[0] = 1.0;
        Self { a, external: motor.clone(), motor, position }
    }

    pub(super) fn states(&self) -> usize {
        self.position.len()
    }

    pub(super) fn derivative(&self, i: usize, state: &[f64], motor_n: f64, external_n: f64) -> f64 {
        let inner: f64 = self.a[i].iter().zip(state).map(|(entry, value)| entry * value).sum();
        inner + self.motor[i] * motor_n + self.external[i] * external_n
    }

    pub(super) fn output(&self, state: &[f64]) -> [f64; 2] {
        let value = |row: &[f64]| -> f64 { row.iter().zip(state).map(|(c, x)| c * x).sum() };
        // c B = 0.
        let velocity = self.position.iter().zip(&self.a).map(|(c, row)| c * value(row)).sum();
        [value(&self.position), velocity]
    }

    pub(super) fn rest_of_function(&self, position_m: f64, [motor_n, external_n]: [f64; 2]) -> State {
        let at =
            |i: usize| -self.a[i - 1][0] * position_m - self.motor[i - 1] * motor_n - self.external[i - 1] * external_n;
        State::from_fn(self.position.len(), |i, _| if i == 0 { position_m } else { at(i) })
    }

    /// Solves `A x + b_u u + b_w w = 0`.
    pub(super) fn rest_of_matrices(&self, position_m: f64, [motor_n, external_n]: [f64; 2]) -> Option<State> {
        let n = self.position.len();
        let entry = |i: usize, j: usize| if i < n { self.a[i][j] } else { self.position[j] };
        let right = |i: usize| {
            if i < n { -self.motor[i] * motor_n - self.external[i] * external_n } else { position_m }
        };
        // So that small coefficients count.
        let scale: Vec<f64> =
            (0..=n).map(|i| (0..n).map(|j| entry(i, j).abs()).fold(f64::MIN_POSITIVE, f64::max)).collect();
        let matrix = nalgebra::DMatrix::from_fn(n + 1, n, |i, j| entry(i, j) / scale[i]);
        let right = State::from_fn(n + 1, |i, _| right(i) / scale[i]);
        let found = matrix.svd(true, true).solve(&right, 1e-14).ok()?;
        found.iter().all(|value| value.is_finite()).then_some(found)
    }
}
