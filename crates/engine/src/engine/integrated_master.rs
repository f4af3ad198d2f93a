//! An independent check of the exact step, integrated at a tenth of the tick; a change of the velocity's sign within it
//! stops the mass.

use nalgebra::DVector;

use super::integrated_slave::Equations;
use super::integrator::integrate;
use super::{Differential, IntegrationError, MasterOutput};
use crate::plant::{ArmParameters, GeneralMaster, MasterModel, PlantError};

const PARTS: usize = 10;

type State = DVector<f64>;

struct Driven<'a> {
    master: &'a IntegratedMaster,
    desired_m_per_s: f64,
    motor_n: f64,
    external_n: f64,
    is_held: bool,
}

impl Differential<State> for Driven<'_> {
    fn system(&self, state: &State, derivative: &mut State) {
        let IntegratedMaster { equations, arm, .. } = self.master;
        let n = equations.states();
        let (arm_m, arm_m_per_s, desired_m) = (state[n], state[n + 1], state[n + 2]);
        let hand_n = self.master.hand_force_n(state);
        for i in 0..n {
            let held = equations.derivative(i, state.as_slice(), self.motor_n, hand_n + self.external_n);
            derivative[i] = if self.is_held { 0.0 } else { held };
        }
        derivative[n] = arm_m_per_s;
        derivative[n + 1] =
            (arm.k_h_n_per_m * (desired_m - arm_m) + arm.b_h_n_s_per_m * (self.desired_m_per_s - arm_m_per_s) - hand_n)
                / arm.m_h_kg;
        derivative[n + 2] = self.desired_m_per_s;
    }
}

#[derive(Debug, Clone)]
pub(super) struct IntegratedMaster {
    equations: Equations,
    arm: ArmParameters,
    friction_n: f64,
    constant_n: f64,
    tick_s: f64,
    state: State,
}

impl IntegratedMaster {
    pub(super) fn new(
        master: &GeneralMaster<'_>,
        tick_s: f64,
        [position_m, arm_m, motor_n]: [f64; 3],
        desired_m: f64,
    ) -> Result<Self, PlantError> {
        let GeneralMaster { parameters, model, arm } = master;
        let equations = match model.model {
            MasterModel::Appendix | MasterModel::MassDamper => {
                Equations::of_mass(parameters.mass_kg, parameters.damping_n_s_per_m)
            }
            MasterModel::TransferFunction => Equations::of_function(&model.numerator, &model.denominator),
            MasterModel::StateSpace => Equations::of_matrices(&model.a, &model.b, &model.c),
        };
        let hand_n = arm.k_a_n_per_m * (arm_m - position_m);
        let forces = [motor_n, hand_n + model.constant_force_n];
        let rest = match model.model {
            MasterModel::Appendix | MasterModel::MassDamper => Some(State::from_vec(vec![position_m, 0.0])),
            MasterModel::TransferFunction => Some(equations.rest_of_function(position_m, forces)),
            MasterModel::StateSpace => equations.rest_of_matrices(position_m, forces),
        };
        let rest = rest.ok_or(PlantError::NoRest { side: "master", start_m: desired_m })?;
        let mut state = rest.as_slice().to_vec();
        state.extend([arm_m, 0.0, desired_m]);
        Ok(Self {
            equations,
            arm: **arm,
            friction_n: if model.has_coulomb_friction() { model.coulomb_friction_n } else { 0.0 },
            constant_n: model.constant_force_n,
            tick_s,
            state: State::from_vec(state),
        })
    }

    pub(super) fn output(&self) -> MasterOutput<f64> {
        let [position_m, velocity_m_per_s] = self.equations.output(self.state.as_slice());
        MasterOutput { position_m, velocity_m_per_s, hand_force_n: self.hand_force_n(&self.state) }
    }

    fn hand_force_n(&self, state: &State) -> f64 {
        let n = self.equations.states();
        let [position_m, velocity_m_per_s] = self.equations.output(state.as_slice());
        self.arm.k_a_n_per_m * (state[n] - position_m) + self.arm.b_a_n_s_per_m * (state[n + 1] - velocity_m_per_s)
    }

    pub(super) fn advance(&mut self, desired_m: [f64; 2], motor_n: f64) -> Result<(), IntegrationError> {
        let (n, part_s) = (self.equations.states(), self.tick_s / PARTS as f64);
        self.state[n + 2] = desired_m[0];
        let desired_m_per_s = (desired_m[1] - desired_m[0]) / self.tick_s;
        for _ in 0..PARTS {
            let net_n = motor_n + self.constant_n + self.hand_force_n(&self.state);
            let velocity = self.state[1];
            let is_held = self.friction_n > 0.0 && velocity == 0.0 && net_n.abs() <= self.friction_n;
            let direction = if velocity == 0.0 { net_n.signum() } else { velocity.signum() };
            let friction_n = if is_held || self.friction_n == 0.0 { 0.0 } else { direction * self.friction_n };
            let external_n = self.constant_n - friction_n;
            let driven = Driven { master: self, desired_m_per_s, motor_n, external_n, is_held };
            let mut state = self.state.clone();
            integrate(driven, part_s, &mut state)?;
            self.state = state;
            if self.friction_n > 0.0 && !is_held && self.state[1] * direction <= 0.0 {
                self.state[1] = 0.0;
            }
        }
        Ok(())
    }
}
