//! Eq. 28-35, stepped exactly. Where the printed appendix cannot have been simulated, a plausible reading is the
//! default.

mod actuator;
mod armed_step;
mod control;
mod machine_step;
mod master;
mod master_model;
mod model;
mod slave;
mod sliding;
mod stick_slip;

pub use actuator::{ActuatorLimits, MotorStep};
pub use armed_step::{ArmedColumn, ArmedRest, ArmedStep, MAX_ARMED_STATES};
pub use control::{SampledController, SampledGains, SlaveController};
pub use machine_step::{MachineColumn, MachineStep, Rest};
pub use master::{ArmParameters, ArmRoles, Coupling, Grip, MasterParameters, MasterStep, master_system};
pub use master_model::{GeneralMaster, MasterModel, MasterModelSettings};
pub use model::{MAX_MACHINE_STATES, Machine, SlaveModel};
pub use slave::{Damping, SlaveParameters, SlaveStep, slave_system};
pub use sliding::SlidingMass;

use thiserror::Error;

use trocar_core::error::InvalidValue;
use trocar_lti as lti;

/// `x_h, v_h, x_a, v_a, ∫(F_ed - F_h)`.
pub const MASTER_STATES: usize = 5;

/// `x_e, v_e` and one state without a physical meaning.
pub const SLAVE_STATES: usize = 3;

trocar_core::choice! {
    /// Timing of the controllers: continuous, or on the tick with held outputs.
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    pub enum ControlTiming at "simulation.control" = Continuous {
        "continuous" => Continuous,
        "sampled" => Sampled,
    }
}

#[derive(Debug, Clone, PartialEq, Error)]
pub enum PlantError {
    #[error(transparent)]
    Parameter(#[from] InvalidValue),
    #[error("the {side} side cannot be built: {source}")]
    Build {
        /// `"master"` or `"slave"`.
        side: &'static str,
        source: lti::Error,
    },
    #[error(
        "slave.denominator of degree {denominator} under slave.numerator of degree {numerator}: the denominator must be of \
         degree 2 or 3 and at least 2 above the numerator, so that the slave has a position and a velocity"
    )]
    SlaveDegree {
        /// Degree.
        numerator: usize,
        denominator: usize,
    },
    #[error(
        "{side}.denominator of degree {denominator} under {side}.numerator of degree {numerator}: the denominator must be \
         at least 2 above a numerator other than 0, so that a force changes the velocity gradually"
    )]
    Improper {
        side: &'static str,
        /// Degree.
        numerator: usize,
        denominator: usize,
    },
    #[error("{side}.{key} lets a force change the velocity at once: c b must be 0, so that the machine has a velocity")]
    VelocityJumps {
        side: &'static str,
        /// Of the input matrix or the numerator.
        key: &'static str,
    },
    #[error("{side}.{key} describes a machine with {states} states, must be at most {MAX_MACHINE_STATES}")]
    TooManyStates {
        side: &'static str,
        /// Of the model.
        key: &'static str,
        states: usize,
    },
    #[error("{side}.c has {states} numbers, must have one per state and at least 2, for position and velocity")]
    TooFewStates {
        side: &'static str,
        /// Length of c.
        states: usize,
    },
    #[error("{side}.{key} has {found} numbers, must have {expected}, row by row, for the {states} states of {side}.c")]
    Size {
        side: &'static str,
        /// Of the matrix.
        key: &'static str,
        found: usize,
        expected: usize,
        states: usize,
    },
    #[error(
        "{side}.{key} describes an unstable machine: it has a pole at {re:.6} ± {im:.6}j 1/s, must be stable or marginal"
    )]
    Unstable {
        side: &'static str,
        key: &'static str,
        /// In 1/s.
        re: f64,
        im: f64,
    },
    #[error("the {side} cannot rest at its start of {start_m} m: no motor force holds it there")]
    NoRest {
        side: &'static str,
        /// Desired position or reference.
        start_m: f64,
    },
}

impl PlantError {
    pub fn of_model(&self) -> Option<(String, String)> {
        let (side, key, remedy) = match self {
            Self::Improper { side, .. } => {
                (side, "numerator", "check the coefficients, highest power first, from force to position")
            }
            Self::VelocityJumps { side, key } => (
                side,
                *key,
                "describe a machine whose acceleration follows the force, with the force in N as the input",
            ),
            Self::TooManyStates { side, key, .. } => (side, *key, "reduce the order of the model"),
            Self::TooFewStates { side, .. } => (side, "c", "give a, b and c, row by row"),
            Self::Size { side, key, .. } => {
                (side, *key, "a is n x n, b n x 2 (motor, external force), c 1 x n, row by row")
            }
            Self::Unstable { side, key, .. } => {
                (side, *key, "check the signs; the controller is not a part of the model")
            }
            Self::NoRest { side, .. } => (side, "model", "check the model, or let the operator start at 0"),
            Self::Parameter(_) | Self::Build { .. } | Self::SlaveDegree { .. } => return None,
        };
        Some((format!("{side}.{key}"), remedy.to_owned()))
    }
}

fn on(side: &'static str) -> impl Fn(lti::Error) -> PlantError {
    move |source| PlantError::Build { side, source }
}
