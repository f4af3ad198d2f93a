//! Settings shared by the schemes that limit force and reference.

trocar_core::settings! {
    /// Damping at the master.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct DampingSettings in "passivity." {
        /// Maximum damping added at the master while energy is short; below 2 m / T with the master's mass m and the
        /// tick T.
        damping_limit_n_s_per_m: f64 [NON_NEGATIVE] = 50.0,
    }
}

trocar_core::settings! {
    /// Limits of the slave's motion.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct CatchUpSettings in "passivity." {
        /// Speed at which the slave catches up after it was held back.
        catch_up_speed_m_per_s: f64 [POSITIVE] = 0.03,
        /// Largest stiffness of the tissue for which a scheme keeps its promise: the slave reserves the energy for
        /// braking against it.
        ///
        /// It limits the slave's speed to the speed that its account pays for at a sudden contact: with 8 mJ and 20
        /// kN/m to about 0.2 m/s.
        max_stiffness_n_per_m: f64 [POSITIVE] = 2e4,
    }
}

trocar_core::settings! {
    /// The energy budget.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct BudgetSettings in "passivity." {
        /// Energy that each port may deliver before it receives any (time-domain, wave-variables).
        ///
        /// The scheme promises `E_m - E_s >= -2 budget_j`. The default pays for a round trip of 0.1 s in tissue: 2 N at
        /// 30 mm/s take 6 mJ before the first energy of the hand arrives.
        budget_j: f64 [POSITIVE] = 1e-2,
    }
}

impl DampingSettings {
    pub(super) fn with_key(&self) -> (&'static str, f64) {
        ("passivity.damping_limit_n_s_per_m", self.damping_limit_n_s_per_m)
    }
}
