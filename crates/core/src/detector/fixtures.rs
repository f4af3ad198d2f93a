//! Samples for the tests of detectors and distances.

use super::DetectorInput;

/// A sample in contact without force, motion or residual.
pub(super) const QUIET: DetectorInput<f64> = DetectorInput {
    force_n: 0.0,
    predicted_force_n: 0.0,
    residual_n: 0.0,
    correction: [0.0; 2],
    depth_m: 0.02,
    velocity_m_per_s: 0.0,
    in_contact: true,
};

pub(super) fn with_force(force_n: f64) -> DetectorInput<f64> {
    DetectorInput { force_n, ..QUIET }
}

/// A sample whose force deviates from a predicted 5 N by a residual in N.
pub(super) fn with_residual(residual_n: f64) -> DetectorInput<f64> {
    DetectorInput { force_n: 5.0 + residual_n, predicted_force_n: 5.0, residual_n, ..QUIET }
}

/// A deterministic sequence of numbers, uniformly distributed between -1 and 1.
pub(super) struct Noise(pub(super) u64);

impl Noise {
    pub(super) fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        2.0 * ((self.0 >> 11) as f64 / (1_u64 << 53) as f64) - 1.0
    }
}
