//! What the motors of both sides can do.

use crate::error::{InvalidValue, positive};

/// Limits on what the controllers command, the same either way; `None` is without a limit.
///
/// A limit acts on the held output of a controller that runs on the tick
/// ([`ControlTiming::Sampled`](super::ControlTiming)): when a continuous one would saturate between ticks is not known
/// beforehand, so that no exact step exists.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ActuatorLimits {
    /// Greatest `|U_m|` in N, above 0.
    pub master_force_n: Option<f64>,
    /// Greatest `|U_s|` in the unit of the slave's command, above 0.
    pub slave_command: Option<f64>,
}

impl ActuatorLimits {
    /// Whether nothing is limited.
    #[must_use]
    pub fn are_none(&self) -> bool {
        *self == Self::default()
    }

    /// Checks the ranges that the fields state.
    ///
    /// # Errors
    /// [`InvalidValue`] naming the first limit out of range.
    pub fn validate(&self) -> Result<(), InvalidValue> {
        for (name, limit) in [
            ("actuator.master_force_limit_n", self.master_force_n),
            ("actuator.slave_command_limit", self.slave_command),
        ] {
            limit.map_or(Ok(0.0), |limit| positive(name, limit))?;
        }
        Ok(())
    }

    /// Greatest `|U_m|` in N, infinite without a limit.
    #[must_use]
    pub fn greatest_master_force_n(&self) -> f64 {
        self.master_force_n.unwrap_or(f64::INFINITY)
    }

    /// Greatest `|U_s|`, infinite without a limit.
    #[must_use]
    pub fn greatest_slave_command(&self) -> f64 {
        self.slave_command.unwrap_or(f64::INFINITY)
    }
}
