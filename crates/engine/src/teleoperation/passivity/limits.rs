trocar_core::settings! {
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct DampingSettings in "passivity." {
        /// Maximum damping added at the master while energy is short; below 2 m / T with the master's mass m and the
        /// tick T.
        damping_limit_n_s_per_m: f64 [NON_NEGATIVE] = 50.0,
    }
}

trocar_core::settings! {
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct CatchUpSettings in "passivity." {
        /// Speed at which the slave catches up after it was held back.
        catch_up_speed_m_per_s: f64 [POSITIVE] = 0.03,
        /// Largest stiffness of the tissue for which a scheme keeps its promise: the slave reserves the energy for
        /// braking against it.
        max_stiffness_n_per_m: f64 [POSITIVE] = 2e4,
    }
}

trocar_core::settings! {
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct BudgetSettings in "passivity." {
        /// Energy that each port may deliver before it receives any (time-domain, wave-variables).
        budget_j: f64 [POSITIVE] = 1e-2,
    }
}

impl DampingSettings {
    pub(super) fn with_key(&self) -> (&'static str, f64) {
        ("passivity.damping_limit_n_s_per_m", self.damping_limit_n_s_per_m)
    }
}
