//! Settings shared by the schemes that limit force and reference.

trocar_core::settings! {
    /// Damping at the master.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct DampingSettings in "passivity." {
        /// Maximum damping added at the master (time-domain, energy-tank).
        damping_limit_n_s_per_m: f64 [NON_NEGATIVE] = 50.0,
    }
}

trocar_core::settings! {
    /// Catch-up of the slave's reference.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct CatchUpSettings in "passivity." {
        /// Speed at which a slave that was held back catches up (time-domain, energy-tank).
        catch_up_speed_m_per_s: f64 [POSITIVE] = 0.03,
    }
}
