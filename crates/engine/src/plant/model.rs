//! The models of a slave, and the linear machine that each describes.

use nalgebra::DMatrix;

use super::{PlantError, SlaveParameters, on};
use trocar_lti::{Continuous, StateSpace, TransferFunction, outputs_first, realise};

/// Largest number of states of a machine.
pub const MAX_MACHINE_STATES: usize = 8;

/// Size of `c B` relative to its factors below which a force changes the velocity gradually.
const NO_JUMP: f64 = 1e-9;

/// Real part of a pole relative to the largest pole (at least 1/s) up to which a machine counts as stable. Several poles
/// at 0 are found with an error of about the square root of the rounding.
const MARGINAL: f64 = 1e-6;

trocar_core::choice! {
    /// Model of the slave without its controller.
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    pub enum SlaveModel at "slave.model" = Appendix {
        /// The transfer function X_e / U_s of eq. 30, on which the tissue's force does not act.
        "appendix" => Appendix,
        /// A mass with viscous and Coulomb friction.
        "mass-damper" => MassDamper,
        /// A transfer function from force to position.
        "transfer-function" => TransferFunction,
        /// A state-space model from motor force and external force to position.
        "state-space" => StateSpace,
    }
}

/// A linear machine. Inputs: the motor's force and an external force in the direction of insertion (N). Outputs and
/// first states: position (m) and velocity (m/s).
#[derive(Debug, Clone, PartialEq)]
pub struct Machine {
    system: StateSpace<Continuous>,
}

impl Machine {
    /// Returns the machine of a slave, without Coulomb friction. With the appendix' model, the input is the command
    /// `U_s`, and the external force has no effect.
    ///
    /// # Errors
    /// [`PlantError`] for a parameter out of range, matrices of wrong sizes, too many states, a force that changes the
    /// velocity at once, or an unstable machine.
    pub fn of(slave: &SlaveParameters) -> Result<Self, PlantError> {
        slave.validate()?;
        let (system, key) = match slave.model {
            SlaveModel::Appendix | SlaveModel::TransferFunction => {
                (of_function(&slave.numerator, &slave.denominator)?, "slave.denominator")
            }
            SlaveModel::MassDamper => {
                (of_function(&[1.0], &[slave.mass_kg, slave.damping_n_s_per_m, 0.0])?, "slave.mass_kg")
            }
            SlaveModel::StateSpace => (of_matrices(&slave.a, &slave.b, &slave.c)?, "slave.a"),
        };
        if system.states() > MAX_MACHINE_STATES {
            return Err(PlantError::TooManyStates { key, states: system.states() });
        }
        let poles = system.poles().map_err(on("slave"))?;
        let largest = poles.iter().map(|pole| pole.norm()).fold(1.0, f64::max);
        if let Some(pole) = poles.iter().find(|pole| pole.re > MARGINAL * largest) {
            return Err(PlantError::Unstable { key, re: pole.re, im: pole.im.abs() });
        }
        let velocity = system.c() * system.a();
        let jump = system.c() * system.b();
        if jump.amax() > NO_JUMP * system.c().norm() * system.b().norm() {
            return Err(PlantError::VelocityJumps {
                key: if key == "slave.a" { "slave.b" } else { "slave.numerator" },
            });
        }
        let outputs = DMatrix::from_rows(&[system.c().row(0), velocity.row(0)]);
        let direct = DMatrix::zeros(2, system.inputs());
        let system = StateSpace::continuous(system.a().clone(), system.b().clone(), outputs, direct);
        let system = system.and_then(|system| outputs_first(&system, &[0, 1])).map_err(on("slave"))?;
        let mut system = balanced(&system, 2).map_err(on("slave"))?;
        if slave.model == SlaveModel::Appendix || !slave.load {
            let mut b = system.b().clone();
            b.column_mut(1).fill(0.0);
            system = StateSpace::continuous(system.a().clone(), b, system.c().clone(), system.d().clone())
                .map_err(on("slave"))?;
        }
        Ok(Self { system })
    }

    /// Returns the system.
    #[must_use]
    pub fn system(&self) -> &StateSpace<Continuous> {
        &self.system
    }
}

/// A transfer function from both forces to the position.
fn of_function(numerator: &[f64], denominator: &[f64]) -> Result<StateSpace<Continuous>, PlantError> {
    let leading = numerator.iter().position(|&value| value != 0.0).unwrap_or(numerator.len());
    let degrees = ((numerator.len() - leading).saturating_sub(1), denominator.len().saturating_sub(1));
    if degrees.1 > MAX_MACHINE_STATES {
        return Err(PlantError::TooManyStates { key: "slave.denominator", states: degrees.1 });
    }
    let function = TransferFunction::new(numerator, denominator).map_err(on("slave"))?;
    if function.relative_degree().is_none_or(|degree| degree < 2) {
        return Err(PlantError::Improper { numerator: degrees.0, denominator: degrees.1 });
    }
    let single = balanced(&realise(&function).map_err(on("slave"))?, 0).map_err(on("slave"))?;
    let b = single.b().column(0);
    let b = DMatrix::from_columns(&[b, b]);
    StateSpace::continuous(single.a().clone(), b, single.c().clone(), DMatrix::zeros(1, 2)).map_err(on("slave"))
}

/// Matrices row by row: A (n x n), B (n x 2), C (1 x n).
fn of_matrices(a: &[f64], b: &[f64], c: &[f64]) -> Result<StateSpace<Continuous>, PlantError> {
    let states = c.len();
    if states > MAX_MACHINE_STATES {
        return Err(PlantError::TooManyStates { key: "slave.c", states });
    }
    if states < 2 {
        return Err(PlantError::TooFewStates { states });
    }
    for (key, found, expected) in [("slave.a", a.len(), states * states), ("slave.b", b.len(), states * 2)] {
        if found != expected {
            return Err(PlantError::Size { key, found, expected, states });
        }
    }
    let (a, b) = (DMatrix::from_row_slice(states, states, a), DMatrix::from_row_slice(states, 2, b));
    let system = StateSpace::continuous(a, b, DMatrix::from_row_slice(1, states, c), DMatrix::zeros(1, 2));
    system.and_then(|system| balanced(&system, 0)).map_err(on("slave"))
}

/// Scales all states but the first ones by powers of two, which is exact. The row and the column of each state in A then
/// have similar sizes (Osborne, *On pre-conditioning of matrices*, 1960).
fn balanced(system: &StateSpace<Continuous>, first: usize) -> Result<StateSpace<Continuous>, trocar_lti::Error> {
    const SWEEPS: usize = 30;
    let n = system.states();
    let (mut a, mut b, mut c) = (system.a().clone(), system.b().clone(), system.c().clone());
    for _ in 0..SWEEPS {
        let mut has_changed = false;
        for i in first..n {
            let of = |entry: &dyn Fn(usize) -> f64| -> f64 { (0..n).filter(|j| *j != i).map(|j| entry(j).abs()).sum() };
            let (column, row) = (of(&|j| a[(j, i)]), of(&|j| a[(i, j)]));
            if column == 0.0 || row == 0.0 || !(column + row).is_finite() {
                continue;
            }
            let power = (0.5 * (row / column).log2()).round();
            if power != 0.0 {
                let scale = power.exp2();
                has_changed = true;
                a.column_mut(i).scale_mut(scale);
                a.row_mut(i).unscale_mut(scale);
                c.column_mut(i).scale_mut(scale);
                b.row_mut(i).unscale_mut(scale);
            }
        }
        if !has_changed {
            break;
        }
    }
    StateSpace::continuous(a, b, c, system.d().clone())
}
