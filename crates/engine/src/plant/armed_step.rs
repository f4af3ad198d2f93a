use nalgebra::{DMatrix, DVector};

use super::machine_step::solve;
use super::master_model::GeneralMaster;
use super::stick_slip::StickSlip;
use super::{ArmParameters, MAX_MACHINE_STATES, PlantError, on};
use trocar_lti::{Continuous, InputHold, StateSpace, exact_step};

pub const MAX_ARMED_STATES: usize = MAX_MACHINE_STATES + 2;

pub type ArmedColumn = [f64; MAX_ARMED_STATES];

/// Desired position and velocity, motor force, external force.
pub(super) const HOLDS: [InputHold; 4] = [InputHold::Linear, InputHold::Held, InputHold::Held, InputHold::Held];

/// `x_{k+1} = transition · x_k + desired_now · x_d(k) + desired_next · x_d(k+1) + motor · u_k + constant`, with `x_d`
/// linear and `u` held. The machine's states (position and velocity first) precede the arm's.
#[derive(Debug, Clone, PartialEq)]
pub struct ArmedStep {
    pub states: usize,
    pub transition: [ArmedColumn; MAX_ARMED_STATES],
    pub desired_now: ArmedColumn,
    pub desired_next: ArmedColumn,
    pub motor: ArmedColumn,
    pub constant: ArmedColumn,
    pub hand_force: ArmedColumn,
    /// Replaces the matrices, which leave out the friction.
    friction: Option<Box<StickSlip>>,
}

impl ArmedStep {
    pub fn new(master: &GeneralMaster<'_>, tick_s: f64) -> Result<Self, PlantError> {
        let system = armed(master)?;
        let step = exact_step(&system, tick_s, &HOLDS).map_err(on("master"))?;
        let states = system.states();
        let column = |matrix: &DMatrix<f64>, j: usize| -> ArmedColumn {
            std::array::from_fn(|i| if i < states && j < matrix.ncols() { matrix[(i, j)] } else { 0.0 })
        };
        let [now, slope] = [0, 1].map(|j| column(&step.gamma_now, j));
        let next = column(&step.gamma_next, 0);
        let constant_n = master.model.constant_force_n;
        let friction =
            master.model.has_coulomb_friction().then(|| StickSlip::new(master, &system, tick_s)).transpose()?;
        Ok(Self {
            states,
            transition: std::array::from_fn(|j| column(&step.phi, j)),
            desired_now: std::array::from_fn(|i| now[i] - slope[i] / tick_s),
            desired_next: std::array::from_fn(|i| next[i] + slope[i] / tick_s),
            motor: column(&step.gamma_now, 2),
            constant: column(&step.gamma_now, 3).map(|effect| effect * constant_n),
            hand_force: std::array::from_fn(|j| if j < states { system.c()[(0, j)] } else { 0.0 }),
            friction: friction.map(Box::new),
        })
    }

    pub fn advance(&self, state: &ArmedColumn, desired_m: [f64; 2], motor_n: f64) -> ArmedColumn {
        let mut next = [0.0; MAX_ARMED_STATES];
        if let Some(friction) = &self.friction {
            let moved = friction.advance([state[0], state[1], state[2], state[3]], desired_m, motor_n);
            next[..4].copy_from_slice(&moved);
            return next;
        }
        for (column, value) in self.transition[..self.states].iter().zip(state) {
            for (sum, entry) in next.iter_mut().zip(column) {
                *sum += entry * value;
            }
        }
        let inputs = [(&self.desired_now, desired_m[0]), (&self.desired_next, desired_m[1]), (&self.motor, motor_n)];
        for (column, value) in inputs {
            for (sum, entry) in next.iter_mut().zip(column) {
                *sum += entry * value;
            }
        }
        for (sum, constant) in next.iter_mut().zip(&self.constant) {
            *sum += constant;
        }
        next
    }

    pub fn hand_force_n(&self, state: &ArmedColumn) -> f64 {
        self.hand_force.iter().zip(state).map(|(gain, value)| gain * value).sum()
    }
}

/// `k_a (x_a - x_h) + b_a (x_a' - x_h')`
fn hand_row(arm: &ArmParameters, states: usize, arm_at: usize) -> DVector<f64> {
    let (k_a, b_a) = (arm.k_a_n_per_m, arm.b_a_n_s_per_m);
    let mut row = DVector::zeros(states);
    (row[0], row[1], row[arm_at], row[arm_at + 1]) = (-k_a, -b_a, k_a, b_a);
    row
}

fn armed(master: &GeneralMaster<'_>) -> Result<StateSpace<Continuous>, PlantError> {
    let machine = master.machine()?;
    let machine = machine.system();
    let (arm, n) = (master.arm, machine.states());
    let (states, at) = (n + 2, n);
    let hand = hand_row(arm, states, at);
    let (mut a, mut b) = (DMatrix::zeros(states, states), DMatrix::zeros(states, 4));
    a.view_mut((0, 0), (n, n)).copy_from(machine.a());
    b.view_mut((0, 2), (n, 2)).copy_from(machine.b());
    let of_external = b.column(3).into_owned();
    a += of_external * hand.transpose();
    a[(at, at + 1)] = 1.0;
    let mut of_arm = -hand.clone();
    of_arm[at] -= arm.k_h_n_per_m;
    of_arm[at + 1] -= arm.b_h_n_s_per_m;
    a.row_mut(at + 1).copy_from(&(of_arm / arm.m_h_kg).transpose());
    b[(at + 1, 0)] = arm.k_h_n_per_m / arm.m_h_kg;
    b[(at + 1, 1)] = arm.b_h_n_s_per_m / arm.m_h_kg;
    let c = DMatrix::from_row_slice(1, states, hand.as_slice());
    StateSpace::continuous(a, b, c, DMatrix::zeros(1, 4)).map_err(on("master"))
}

#[derive(Debug, Clone, PartialEq)]
pub struct ArmedRest {
    pub state: ArmedColumn,
    pub motor_n: f64,
}

impl ArmedRest {
    /// With a force integral the hand feels no force, else the motor is off.
    pub fn of(master: &GeneralMaster<'_>, desired_m: f64) -> Result<Self, PlantError> {
        let system = armed(master)?;
        let n = system.states();
        let mut matrix = DMatrix::zeros(n + 1, n + 1);
        matrix.view_mut((0, 0), (n, n)).copy_from(system.a());
        matrix.view_mut((0, n), (n, 1)).copy_from(&system.b().column(2));
        let mut right = DVector::zeros(n + 1);
        let given = system.b().column(0) * desired_m + system.b().column(3) * master.model.constant_force_n;
        right.rows_mut(0, n).copy_from(&-given);
        if master.parameters.force_integral_gain > 0.0 {
            matrix.view_mut((n, 0), (1, n)).copy_from(&system.c().row(0));
        } else {
            matrix[(n, n)] = 1.0;
        }
        let found = solve(matrix, &right).ok_or(PlantError::NoRest { side: "master", start_m: desired_m })?;
        let mut state: ArmedColumn = std::array::from_fn(|i| if i < n { found[i] } else { 0.0 });
        // Rounding would release a mass that friction holds.
        state[1] = 0.0;
        Ok(Self { state, motor_n: found[n] })
    }
}
