use crate::estimation::Parameters;

crate::settings! {
    /// The residual under the hypotheses of eq. 19.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct Hypotheses in "detector." {
        /// σ_0: standard deviation of the residual without a rupture.
        ///
        /// The paper measured 0.02 N.
        quiet_std_n: f64 [POSITIVE] = 0.02,
        /// σ_1: standard deviation of the residual after a rupture.
        ///
        /// The paper: at least 0.2 N.
        rupture_std_n: f64 [POSITIVE] = 0.2,
        /// m_1 of eq. 22: mean of the residual after a rupture.
        ///
        /// Negative, because the force falls below the prediction.
        rupture_mean_n: f64 [ANY] = -0.2,
        /// Correction of the stiffness by a rupture, for eq. 26.
        stiffness_change_n_per_m: f64 [POSITIVE] = 20.0,
        /// Correction of the damping by a rupture, for eq. 26.
        ///
        /// The first rupture of the shipped insertion corrects it by up to 21 N·s/m in one sample.
        damping_change_n_s_per_m: f64 [POSITIVE]
            for Parameters::StiffnessAndDamping | StiffnessDampingFriction | HuntCrossley | LeastResidual = 20.0,
    }
    where rupture_std_n: |s| s.rupture_std_n > s.quiet_std_n, "above detector.quiet_std_n";
    where rupture_mean_n: |s| s.rupture_mean_n != 0.0, "a finite number other than 0";
}

impl Hypotheses {
    /// For a squared quantity (4.6): `γ = (σ_1² - σ_0²)/2`, `ν = (σ_1² + σ_0²)/2`.
    pub(super) fn squared_tuning(&self) -> (f64, f64) {
        let (quiet, changed) = (self.quiet_std_n * self.quiet_std_n, self.rupture_std_n * self.rupture_std_n);
        ((changed - quiet) / 2.0, (changed + quiet) / 2.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rupture_must_widen_the_residual_and_shift_its_mean() {
        let refused = |hypotheses: Hypotheses| hypotheses.validate().err().map(|error| error.name);
        assert_eq!(refused(Hypotheses::default()), None);
        assert_eq!(
            refused(Hypotheses { rupture_std_n: 0.02, ..Hypotheses::default() }),
            Some("detector.rupture_std_n")
        );
        assert_eq!(
            refused(Hypotheses { rupture_mean_n: 0.0, ..Hypotheses::default() }),
            Some("detector.rupture_mean_n")
        );
    }
}
