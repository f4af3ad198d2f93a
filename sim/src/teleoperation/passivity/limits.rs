//! What the schemes that limit force and reference have in common.

use crate::error::{InvalidValue, non_negative, positive};

/// The numbers of every scheme that damps the master and meters the slave's reference.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LimitSettings {
    /// Greatest damping that is added at the master in N·s/m, at least 0.
    pub damping_limit_n_s_per_m: f64,
    /// Speed at which a slave that was held back catches up, in m/s, above 0.
    pub catch_up_speed_m_per_s: f64,
}

impl LimitSettings {
    /// Chosen here.
    pub const DEFAULT: Self = Self { damping_limit_n_s_per_m: 50.0, catch_up_speed_m_per_s: 0.03 };

    /// Checks the ranges that the fields state.
    ///
    /// # Errors
    /// [`InvalidValue`] naming the first setting out of range.
    pub fn validate(&self) -> Result<(), InvalidValue> {
        non_negative("passivity.damping_limit_n_s_per_m", self.damping_limit_n_s_per_m)?;
        positive("passivity.catch_up_speed_m_per_s", self.catch_up_speed_m_per_s)?;
        Ok(())
    }
}
