use crate::machine::Machine;
use crate::measured::{Measured, span};
use crate::structure::Parameter;
use crate::system::{System, relative_errors};
use crate::zero::FreeMotion;

/// Prior around 1: calibrations of force sensors agree within 10 %.
const SCALE_SD: f64 = 0.1;

const OFFSET_SD_PER_RANGE: f64 = 0.05;

const LAG_SD_S: f64 = 5e-3;

/// `zeros_n`: readings without a load, by training recording.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Model {
    pub(crate) machine: Machine,
    pub(crate) zeros_n: Vec<f64>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Unknown {
    Of(Parameter),
    /// By index of the training recording.
    Zero(usize),
}

#[derive(Clone)]
pub(crate) struct SlaveSystem<'a> {
    recordings: &'a [Measured],
    expected_zeros_n: Vec<f64>,
    free_motion: Option<FreeMotion>,
    offset_sd_n: f64,
}

impl<'a> SlaveSystem<'a> {
    /// Expects the zeros of the start.
    pub(crate) fn new(recordings: &'a [Measured], start: &Model, free_motion: Option<FreeMotion>) -> Self {
        let range_n = recordings.iter().map(|one| span(&one.force_n)).fold(0.0, f64::max);
        let offset_sd_n = (OFFSET_SD_PER_RANGE * range_n).max(1e-9);
        Self { recordings, expected_zeros_n: start.zeros_n.clone(), free_motion, offset_sd_n }
    }
}

impl System for SlaveSystem<'_> {
    type Model = Model;
    type Unknown = Unknown;

    fn value(unknown: Unknown, model: &Model) -> f64 {
        match unknown {
            Unknown::Of(parameter) => parameter.of(&model.machine),
            Unknown::Zero(recording) => model.zeros_n[recording],
        }
    }

    fn set(unknown: Unknown, model: &mut Model, value: f64) {
        match unknown {
            Unknown::Of(parameter) => parameter.set(&mut model.machine, value),
            Unknown::Zero(recording) => model.zeros_n[recording] = value,
        }
    }

    fn is_positive(&self, unknown: Unknown) -> bool {
        match unknown {
            Unknown::Of(parameter) => parameter.is_positive(),
            Unknown::Zero(_) => false,
        }
    }

    fn errors(&self, model: &Model) -> Vec<f64> {
        let pairs = self.recordings.iter().zip(&model.zeros_n);
        let errors = |(one, zero_n): (&'_ Measured, &f64)| -> Vec<f64> {
            relative_errors(model.machine.simulate(one, *zero_n), &one.slave_m, 1.0 / one.motion_m()).collect()
        };
        pairs.flat_map(errors).collect()
    }

    fn lengths(&self) -> Vec<usize> {
        self.recordings.iter().map(Measured::len).collect()
    }

    fn expected(&self, unknown: Unknown) -> Option<(f64, f64)> {
        match unknown {
            Unknown::Of(Parameter::Scale) => Some((1.0, SCALE_SD)),
            Unknown::Of(Parameter::Offset) => Some((0.0, self.offset_sd_n)),
            Unknown::Of(Parameter::Lag) => Some((0.0, LAG_SD_S)),
            Unknown::Of(_) => None,
            // The ripple in free motion limits the accuracy of the zero.
            Unknown::Zero(recording) => {
                let width_n = self.free_motion.map_or(0.0, |free| free.width_n);
                Some((self.expected_zeros_n[recording], width_n.max(1e-9)))
            }
        }
    }

    /// Free motion determines the constant force.
    fn prior_sd(&self, unknown: Unknown) -> Option<f64> {
        let is_determined = unknown == Unknown::Of(Parameter::Offset) && self.free_motion.is_some();
        self.expected(unknown).filter(|_| !is_determined).map(|(_, sd)| sd)
    }
}
