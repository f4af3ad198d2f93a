//! Systems with known exact responses, shared by the tests of all layers.

use nalgebra::{DMatrix, dmatrix};
use trocar::lti::{Continuous, StateSpace};

/// `m x'' + b x' = f` from rest; states and outputs x (m), x' (m/s); input f (N). Eq. 28's master is one.
#[derive(Debug, Clone, Copy)]
pub struct MassDamper {
    pub mass_kg: f64,
    pub damping_n_s_per_m: f64,
}

impl MassDamper {
    pub const MASTER: Self = Self { mass_kg: 0.245, damping_n_s_per_m: 4.1 };

    pub fn system(self) -> StateSpace<Continuous> {
        let a = dmatrix![0.0, 1.0; 0.0, -self.damping_n_s_per_m / self.mass_kg];
        let b = dmatrix![0.0; 1.0 / self.mass_kg];
        StateSpace::continuous(a, b, DMatrix::identity(2, 2), DMatrix::zeros(2, 1)).expect("well formed")
    }

    fn time_constant_s(self) -> f64 {
        self.mass_kg / self.damping_n_s_per_m
    }

    /// Returns (x, x') at time t under a constant force: `x' = F/b (1 - e^{-t/τ})`, `x = F/b (t - τ (1 - e^{-t/τ}))`.
    pub fn under_constant_force(self, force_n: f64, t: f64) -> (f64, f64) {
        let tau = self.time_constant_s();
        let speed = force_n / self.damping_n_s_per_m;
        let rise = -f64::exp_m1(-t / tau);
        (speed * (t - tau * rise), speed * rise)
    }

    /// Returns (x, x') at time t under the force `slope · t`: `x' = c/b (t - τ (1 - e^{-t/τ}))`, and its integral.
    pub fn under_ramped_force(self, slope_n_per_s: f64, t: f64) -> (f64, f64) {
        let tau = self.time_constant_s();
        let gain = slope_n_per_s / self.damping_n_s_per_m;
        let rise = -f64::exp_m1(-t / tau);
        (gain * (t * t / 2.0 - tau * t + tau * tau * rise), gain * (t - tau * rise))
    }
}

/// `τ y' + y = u` from rest.
#[derive(Debug, Clone, Copy)]
pub struct Lag {
    pub time_constant_s: f64,
}

impl Lag {
    pub fn system(self) -> StateSpace<Continuous> {
        let rate = 1.0 / self.time_constant_s;
        StateSpace::continuous(dmatrix![-rate], dmatrix![rate], dmatrix![1.0], dmatrix![0.0]).expect("well formed")
    }

    /// Returns y at time t after a unit step: `1 - e^{-t/τ}`.
    pub fn after_unit_step(self, t: f64) -> f64 {
        -f64::exp_m1(-t / self.time_constant_s)
    }
}
