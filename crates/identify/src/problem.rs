use levenberg_marquardt::{LeastSquaresProblem, LevenbergMarquardt};
use nalgebra::{DMatrix, DVector, Dyn, storage::Owned};

use crate::system::System;

/// As an error relative to the motion, per standard deviation.
const FIRST_WEIGHT: f64 = 0.01;

/// Each time, the remaining errors determine the weight of the priors.
const REWEIGHTED: usize = 3;

/// In coordinates.
const STEP: f64 = 1e-4;

/// A factor of e^25 from the start.
const LARGEST: f64 = 25.0;

/// Coordinates of magnitude 1: `ln` of the ratio to the start for positive unknowns, otherwise the deviation from the
/// expected value per standard deviation.
#[derive(Clone)]
pub(crate) struct Problem<S: System> {
    system: S,
    free: Vec<S::Unknown>,
    start: S::Model,
    prior_weight: f64,
    coordinates: DVector<f64>,
}

impl<S: System> Problem<S> {
    pub(crate) fn new(system: S, free: Vec<S::Unknown>, start: S::Model) -> Self {
        let at_start = |unknown: &S::Unknown| {
            system.expected(*unknown).map_or(0.0, |(mean, sd)| (S::value(*unknown, &start) - mean) / sd)
        };
        let coordinates = DVector::from_iterator(free.len(), free.iter().map(at_start));
        Self { system, free, start, prior_weight: FIRST_WEIGHT, coordinates }
    }

    pub(crate) fn free(&self) -> &[S::Unknown] {
        &self.free
    }

    pub(crate) fn system(&self) -> &S {
        &self.system
    }

    /// Relative to the motion, per standard deviation.
    pub(crate) fn prior_weight(&self) -> f64 {
        self.prior_weight
    }

    pub(crate) fn model(&self) -> S::Model {
        self.model_at(&self.coordinates)
    }

    fn model_at(&self, coordinates: &DVector<f64>) -> S::Model {
        let mut model = self.start.clone();
        for (unknown, coordinate) in self.free.iter().zip(coordinates.iter()) {
            let coordinate = coordinate.clamp(-LARGEST, LARGEST);
            let value = match self.system.expected(*unknown) {
                Some((mean, sd)) => mean + sd * coordinate,
                None => S::value(*unknown, &self.start) * coordinate.exp(),
            };
            S::set(*unknown, &mut model, value);
        }
        model
    }

    fn residuals_at(&self, coordinates: &DVector<f64>) -> DVector<f64> {
        let mut residuals = self.system.errors(&self.model_at(coordinates));
        let priors =
            self.free.iter().zip(coordinates.iter()).filter(|(unknown, _)| self.system.prior_sd(**unknown).is_some());
        residuals.extend(priors.map(|(_, coordinate)| self.prior_weight * coordinate));
        DVector::from_vec(residuals)
    }

    /// Returns the minimum sum of squares.
    ///
    /// The errors of a recording are similar, so they count as one observation, and so does each prior.
    pub(crate) fn solve(self) -> (f64, Self) {
        let has_priors = self.free.iter().any(|unknown| self.system.prior_sd(*unknown).is_some());
        let mut solved = self.minimised();
        for _ in 0..if has_priors { REWEIGHTED } else { 0 } {
            let squares: f64 = solved.system.errors(&solved.model()).iter().map(|error| error * error).sum();
            solved.prior_weight = (squares / solved.system.lengths().len() as f64).sqrt().min(FIRST_WEIGHT);
            solved = solved.minimised();
        }
        (solved.residuals_at(&solved.coordinates).norm_squared(), solved)
    }

    fn minimised(self) -> Self {
        let optimiser = LevenbergMarquardt::new().with_ftol(1e-9).with_xtol(1e-6).with_gtol(1e-9).with_patience(40);
        optimiser.minimize(self).0
    }
}

impl<S: System> LeastSquaresProblem<f64, Dyn, Dyn> for Problem<S> {
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
