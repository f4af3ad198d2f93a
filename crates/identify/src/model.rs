//! A machine with the zeros of its force sensor, and the unknowns of both.

use crate::machine::Machine;
use crate::structure::Parameter;

/// A machine, and what its force sensor reads without a load in each training recording, in N.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Model {
    pub(crate) machine: Machine,
    pub(crate) zeros_n: Vec<f64>,
}

/// An unknown of a model.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Unknown {
    /// A parameter of the machine.
    Of(Parameter),
    /// The zero of the force sensor in the training recording with this index.
    Zero(usize),
}

impl Unknown {
    /// Returns the value of a model.
    pub(crate) fn of(self, model: &Model) -> f64 {
        match self {
            Self::Of(parameter) => parameter.of(&model.machine),
            Self::Zero(recording) => model.zeros_n[recording],
        }
    }

    /// Sets the value of a model.
    pub(crate) fn set(self, model: &mut Model, value: f64) {
        match self {
            Self::Of(parameter) => parameter.set(&mut model.machine, value),
            Self::Zero(recording) => model.zeros_n[recording] = value,
        }
    }

    /// Returns true if the unknown is never negative.
    pub(crate) fn is_positive(self) -> bool {
        match self {
            Self::Of(parameter) => parameter.is_positive(),
            Self::Zero(_) => false,
        }
    }
}
