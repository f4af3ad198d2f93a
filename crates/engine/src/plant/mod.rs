//! The machines: the master with the operator's arm, and the slave, each with its controller (eq. 28-35).
//!
//! Each side is built from the paper's transfer functions by interconnection, then stepped exactly over a tick. Where
//! the authors cannot have simulated the printed appendix, a plausible reading is the default; the printed one remains
//! selectable.

mod actuator;
mod master;
mod slave;

pub use actuator::{ActuatorLimits, MotorStep};
pub use master::{ArmParameters, ArmRoles, Coupling, Grip, MasterParameters, MasterStep, master_system};
pub use slave::{Damping, SlaveParameters, SlaveStep, slave_system};

use thiserror::Error;

use trocar_core::error::InvalidValue;
use trocar_lti as lti;

/// Number of states of the master side: `x_h, v_h, x_a, v_a, ∫(F_ed - F_h)`.
pub const MASTER_STATES: usize = 5;

/// Number of states of the slave side: `x_e, v_e` and one state without a physical meaning.
pub const SLAVE_STATES: usize = 3;

trocar_core::choice! {
    /// Timing of the controllers: continuous, or on the tick with held outputs.
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    pub enum ControlTiming at "simulation.control" = Continuous {
        /// In continuous time, as in the appendix.
        "continuous" => Continuous,
        /// On the tick, with held outputs, as a real digital controller would.
        "sampled" => Sampled,
    }
}

/// Error of a side that cannot be built.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum PlantError {
    /// A parameter is out of range.
    #[error(transparent)]
    Parameter(#[from] InvalidValue),
    /// The computation of the side's system failed.
    #[error("the {side} side cannot be built: {source}")]
    Build {
        /// Name of the side.
        side: &'static str,
        /// Error of the computation.
        source: lti::Error,
    },
    /// The slave's transfer function has no position and velocity, or too many states.
    #[error(
        "slave.denominator of degree {denominator} under slave.numerator of degree {numerator}: the denominator must be of \
         degree 2 or 3 and at least 2 above the numerator, so that the slave has a position and a velocity"
    )]
    SlaveDegree {
        /// Degree of the numerator.
        numerator: usize,
        /// Degree of the denominator.
        denominator: usize,
    },
}

/// Adds the side to an error of the computation.
fn on(side: &'static str) -> impl Fn(lti::Error) -> PlantError {
    move |source| PlantError::Build { side, source }
}
