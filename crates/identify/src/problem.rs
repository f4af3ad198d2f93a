//! The least-squares problem of an identification.

use levenberg_marquardt::{LeastSquaresProblem, LevenbergMarquardt};
use nalgebra::{DMatrix, DVector, Dyn, storage::Owned};

use crate::machine::Machine;
use crate::measured::{Measured, span};
use crate::structure::Parameter;

/// The first weight of a prior: one standard deviation counts as much as an error of 1 % of the slave's motion.
const FIRST_WEIGHT: f64 = 0.01;

/// How often the weight of the priors is computed anew from the remaining errors.
const REWEIGHTED: usize = 3;

/// Prior standard deviation of the sensor's scale around 1: calibrations of force sensors agree within 10 %.
const SCALE_SD: f64 = 0.1;

/// Prior standard deviation of the offset, per range of the measured force.
const OFFSET_SD_PER_RANGE: f64 = 0.05;

/// Prior standard deviation of the sensor's lag in s.
const LAG_SD_S: f64 = 5e-3;

/// Step of the numerical derivatives, in coordinates.
const STEP: f64 = 1e-4;

/// Coordinates are limited to this magnitude: a factor of e^25 from the start.
const LARGEST: f64 = 25.0;

/// The unknown parameters of a machine in coordinates of magnitude 1: the logarithm of the ratio to the start for
/// positive parameters, and the deviation from the prior mean per standard deviation for those of the sensor.
#[derive(Clone)]
pub(crate) struct Problem<'a> {
    recordings: &'a [Measured],
    free: Vec<Parameter>,
    start: Machine,
    offset_sd_n: f64,
    prior_weight: f64,
    coordinates: DVector<f64>,
}

impl<'a> Problem<'a> {
    pub(crate) fn new(recordings: &'a [Measured], free: Vec<Parameter>, start: Machine) -> Self {
        let range_n = recordings.iter().map(|one| span(&one.force_n)).fold(0.0, f64::max);
        let offset_sd_n = (OFFSET_SD_PER_RANGE * range_n).max(1e-9);
        let coordinates = DVector::zeros(free.len());
        let mut problem = Self { recordings, free, start, offset_sd_n, prior_weight: FIRST_WEIGHT, coordinates };
        let at_start = |parameter: &Parameter| {
            problem.prior(*parameter).map_or(0.0, |(mean, sd)| (parameter.of(&start) - mean) / sd)
        };
        problem.coordinates = DVector::from_iterator(problem.free.len(), problem.free.iter().map(at_start));
        problem
    }

    pub(crate) fn free(&self) -> &[Parameter] {
        &self.free
    }

    pub(crate) fn recordings(&self) -> &'a [Measured] {
        self.recordings
    }

    /// Returns the weight of a prior: the size of an error, relative to the motion, that counts as one standard
    /// deviation.
    pub(crate) fn prior_weight(&self) -> f64 {
        self.prior_weight
    }

    /// Returns the prior mean and standard deviation of a parameter of the sensor.
    pub(crate) fn prior(&self, parameter: Parameter) -> Option<(f64, f64)> {
        match parameter {
            Parameter::Scale => Some((1.0, SCALE_SD)),
            Parameter::Offset => Some((0.0, self.offset_sd_n)),
            Parameter::Lag => Some((0.0, LAG_SD_S)),
            _ => None,
        }
    }

    /// Returns the machine at the current coordinates.
    pub(crate) fn machine(&self) -> Machine {
        self.machine_at(&self.coordinates)
    }

    fn machine_at(&self, coordinates: &DVector<f64>) -> Machine {
        let mut machine = self.start;
        for (parameter, coordinate) in self.free.iter().zip(coordinates.iter()) {
            let coordinate = coordinate.clamp(-LARGEST, LARGEST);
            let value = match self.prior(*parameter) {
                Some((mean, sd)) => mean + sd * coordinate,
                None => parameter.of(&self.start) * coordinate.exp(),
            };
            parameter.set(&mut machine, value);
        }
        machine
    }

    /// Returns the errors of a machine relative to the motion of each recording. A simulation that diverges has errors
    /// as large as the motion at every sample, so that the optimiser rejects the step.
    pub(crate) fn errors(&self, machine: &Machine) -> Vec<f64> {
        let mut errors = Vec::with_capacity(self.recordings.iter().map(Measured::len).sum());
        for one in self.recordings {
            match machine.simulate(one) {
                Some(simulated) => {
                    let scale = 1.0 / one.motion_m();
                    errors.extend(
                        simulated.iter().zip(&one.slave_m).map(|(simulated, slave)| scale * (simulated - slave)),
                    );
                }
                None => errors.extend(std::iter::repeat_n(1.0, one.len())),
            }
        }
        errors
    }

    fn residuals_at(&self, coordinates: &DVector<f64>) -> DVector<f64> {
        let mut residuals = self.errors(&self.machine_at(coordinates));
        let priors =
            self.free.iter().zip(coordinates.iter()).filter(|(parameter, _)| self.prior(**parameter).is_some());
        residuals.extend(priors.map(|(_, coordinate)| self.prior_weight * coordinate));
        DVector::from_vec(residuals)
    }

    /// Minimises the sum of squares, and returns it with the problem at the minimum.
    ///
    /// What a structure does not explain is alike throughout a recording, so that the errors of a recording count as one
    /// observation, and the priors have the weight of such an observation. They decide little where simulation and
    /// measurement agree, and more where the structure does not explain the recordings.
    pub(crate) fn solve(self) -> (f64, Self) {
        let has_priors = self.free.iter().any(|parameter| self.prior(*parameter).is_some());
        let mut solved = self.minimised();
        for _ in 0..if has_priors { REWEIGHTED } else { 0 } {
            let squares: f64 = solved.errors(&solved.machine()).iter().map(|error| error * error).sum();
            solved.prior_weight = (squares / solved.recordings.len() as f64).sqrt().min(FIRST_WEIGHT);
            solved = solved.minimised();
        }
        (solved.residuals_at(&solved.coordinates).norm_squared(), solved)
    }

    fn minimised(self) -> Self {
        let optimiser = LevenbergMarquardt::new().with_ftol(1e-9).with_xtol(1e-6).with_gtol(1e-9).with_patience(40);
        optimiser.minimize(self).0
    }
}

impl LeastSquaresProblem<f64, Dyn, Dyn> for Problem<'_> {
    type ResidualStorage = Owned<f64, Dyn>;
    type JacobianStorage = Owned<f64, Dyn, Dyn>;
    type ParameterStorage = Owned<f64, Dyn>;

    fn set_params(&mut self, coordinates: &DVector<f64>) {
        self.coordinates.copy_from(coordinates);
    }

    fn params(&self) -> DVector<f64> {
        self.coordinates.clone()
    }

    fn residuals(&self) -> Option<DVector<f64>> {
        Some(self.residuals_at(&self.coordinates))
    }

    fn jacobian(&self) -> Option<DMatrix<f64>> {
        let here = self.residuals_at(&self.coordinates);
        let mut jacobian = DMatrix::zeros(here.len(), self.free.len());
        for column in 0..self.free.len() {
            let mut moved = self.coordinates.clone();
            moved[column] += STEP;
            jacobian.set_column(column, &((self.residuals_at(&moved) - &here) / STEP));
        }
        Some(jacobian)
    }
}
