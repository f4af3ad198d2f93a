//! The least-squares problem of an identification.

use levenberg_marquardt::{LeastSquaresProblem, LevenbergMarquardt};
use nalgebra::{DMatrix, DVector, Dyn, storage::Owned};

use crate::measured::{Measured, span};
use crate::model::{Model, Unknown};
use crate::structure::Parameter;
use crate::zero::FreeMotion;

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

/// The unknowns of a model in coordinates of magnitude 1: the logarithm of the ratio to the start for positive
/// parameters, and the deviation from the expected value per standard deviation for those of the sensor.
#[derive(Clone)]
pub(crate) struct Problem<'a> {
    recordings: &'a [Measured],
    free: Vec<Unknown>,
    start: Model,
    free_motion: Option<FreeMotion>,
    offset_sd_n: f64,
    prior_weight: f64,
    coordinates: DVector<f64>,
}

impl<'a> Problem<'a> {
    /// The zeros of the start are those that are expected.
    pub(crate) fn new(
        recordings: &'a [Measured],
        free: Vec<Unknown>,
        start: Model,
        free_motion: Option<FreeMotion>,
    ) -> Self {
        let range_n = recordings.iter().map(|one| span(&one.force_n)).fold(0.0, f64::max);
        let offset_sd_n = (OFFSET_SD_PER_RANGE * range_n).max(1e-9);
        let coordinates = DVector::zeros(free.len());
        let mut problem =
            Self { recordings, free, start, free_motion, offset_sd_n, prior_weight: FIRST_WEIGHT, coordinates };
        let at_start = |unknown: &Unknown| {
            problem.expected(*unknown).map_or(0.0, |(mean, sd)| (unknown.of(&problem.start) - mean) / sd)
        };
        problem.coordinates = DVector::from_iterator(problem.free.len(), problem.free.iter().map(at_start));
        problem
    }

    pub(crate) fn free(&self) -> &[Unknown] {
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

    /// Returns the expected value and its standard deviation of an unknown that may be negative.
    fn expected(&self, unknown: Unknown) -> Option<(f64, f64)> {
        match unknown {
            Unknown::Of(Parameter::Scale) => Some((1.0, SCALE_SD)),
            Unknown::Of(Parameter::Offset) => Some((0.0, self.offset_sd_n)),
            Unknown::Of(Parameter::Lag) => Some((0.0, LAG_SD_S)),
            Unknown::Of(_) => None,
            // The ripple of the sensor in free motion bounds how exactly its zero is known.
            Unknown::Zero(recording) => {
                let width_n = self.free_motion.map_or(0.0, |free| free.width_n);
                Some((self.start.zeros_n[recording], width_n.max(1e-9)))
            }
        }
    }

    /// Returns the standard deviation of an unknown's prior; `None` without a prior. Free motion determines the constant
    /// force.
    pub(crate) fn prior_sd(&self, unknown: Unknown) -> Option<f64> {
        let is_determined = unknown == Unknown::Of(Parameter::Offset) && self.free_motion.is_some();
        self.expected(unknown).filter(|_| !is_determined).map(|(_, sd)| sd)
    }

    /// Returns the model at the current coordinates.
    pub(crate) fn model(&self) -> Model {
        self.model_at(&self.coordinates)
    }

    fn model_at(&self, coordinates: &DVector<f64>) -> Model {
        let mut model = self.start.clone();
        for (unknown, coordinate) in self.free.iter().zip(coordinates.iter()) {
            let coordinate = coordinate.clamp(-LARGEST, LARGEST);
            let value = match self.expected(*unknown) {
                Some((mean, sd)) => mean + sd * coordinate,
                None => unknown.of(&self.start) * coordinate.exp(),
            };
            unknown.set(&mut model, value);
        }
        model
    }

    /// Returns the errors of a model relative to the motion of each recording. A simulation that diverges has errors as
    /// large as the motion at every sample. The optimiser then rejects the step.
    pub(crate) fn errors(&self, model: &Model) -> Vec<f64> {
        let mut errors = Vec::with_capacity(self.recordings.iter().map(Measured::len).sum());
        for (one, zero_n) in self.recordings.iter().zip(&model.zeros_n) {
            match model.machine.simulate(one, *zero_n) {
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
        let mut residuals = self.errors(&self.model_at(coordinates));
        let priors = self.free.iter().zip(coordinates.iter()).filter(|(unknown, _)| self.prior_sd(**unknown).is_some());
        residuals.extend(priors.map(|(_, coordinate)| self.prior_weight * coordinate));
        DVector::from_vec(residuals)
    }

    /// Minimises the sum of squares, and returns it with the problem at the minimum.
    ///
    /// What a structure does not explain is alike throughout a recording, so that the errors of a recording count as one
    /// observation, and the priors have the weight of such an observation. They decide little where simulation and
    /// measurement agree, and more where the structure does not explain the recordings.
    pub(crate) fn solve(self) -> (f64, Self) {
        let has_priors = self.free.iter().any(|unknown| self.prior_sd(*unknown).is_some());
        let mut solved = self.minimised();
        for _ in 0..if has_priors { REWEIGHTED } else { 0 } {
            let squares: f64 = solved.errors(&solved.model()).iter().map(|error| error * error).sum();
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
