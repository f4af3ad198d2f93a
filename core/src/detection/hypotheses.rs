//! The two hypotheses of eq. 19, of which detectors decide for one.

use crate::error::{InvalidValue, positive, require};

/// What the two hypotheses of eq. 19 say of the residual.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hypotheses {
    /// `σ_0` in N, above 0: spread of the residual when nothing happens (the paper measured 0.02 N).
    pub quiet_std_n: f64,
    /// `σ_1` in N, above `σ_0`: its spread after a rupture (the paper: at least 0.2 N).
    pub rupture_std_n: f64,
    /// `m_1` in N, not 0: its mean after a rupture, for eq. 22; negative as the force falls short.
    pub rupture_mean_n: f64,
    /// Correction of the stiffness in N/m, above 0, that one sample of a rupture causes, for eq. 26.
    pub stiffness_change_n_per_m: f64,
}

impl Hypotheses {
    /// Threshold and drift of a squared quantity: `γ = (σ_1² - σ_0²)/2`, `ν = (σ_1² + σ_0²)/2` (4.6).
    pub(super) fn squared_tuning(&self) -> (f64, f64) {
        let (quiet, changed) = (self.quiet_std_n * self.quiet_std_n, self.rupture_std_n * self.rupture_std_n);
        ((changed - quiet) / 2.0, (changed + quiet) / 2.0)
    }

    /// Checks the ranges that the fields state.
    ///
    /// # Errors
    /// [`InvalidValue`] naming the first one out of range.
    pub fn validate(&self) -> Result<(), InvalidValue> {
        positive("detector.quiet_std_n", self.quiet_std_n)?;
        positive("detector.rupture_std_n", self.rupture_std_n)?;
        let ordered = self.rupture_std_n > self.quiet_std_n;
        require("detector.rupture_std_n", self.rupture_std_n, ordered, "above detector.quiet_std_n")?;
        let shifted = self.rupture_mean_n.is_finite() && self.rupture_mean_n != 0.0;
        require("detector.rupture_mean_n", self.rupture_mean_n, shifted, "a finite number other than 0")?;
        positive("detector.stiffness_change_n_per_m", self.stiffness_change_n_per_m)?;
        Ok(())
    }
}

impl Default for Hypotheses {
    fn default() -> Self {
        Self { quiet_std_n: 0.02, rupture_std_n: 0.2, rupture_mean_n: -0.2, stiffness_change_n_per_m: 20.0 }
    }
}
