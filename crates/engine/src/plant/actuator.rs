//! Limits and lags of the motors of both sides.

use super::{PlantError, on};
use trocar_lti::{Continuous, StateSpace, lagged_input};

trocar_core::settings! {
    /// Limits on the motors' response to the controllers' commands, the same in both directions. `None` means no limit,
    /// a lag of 0 no lag.
    ///
    /// A command is clipped to the range, then its change from the last command is limited. It is held until the next
    /// tick, and the motor follows it with the lag in continuous time.
    ///
    /// The limits act on the held output of a controller that runs on the tick
    /// ([`ControlTiming::Sampled`](super::ControlTiming)). A continuous controller would saturate at unknown times
    /// between ticks, so no exact step would exist.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct ActuatorLimits in "actuator." {
        /// Maximum force U_m of the master's motor, in both directions; no limit by default.
        master_force_n: Option<f64> at "actuator.master_force_limit_n" [POSITIVE],
        /// Maximum command U_s to the slave, in both directions, in the command's unit; no limit by default.
        slave_command: Option<f64> at "actuator.slave_command_limit" [POSITIVE],
        /// Maximum rate of the commanded force of the master's motor; no limit by default.
        master_force_rate_n_per_s: Option<f64> at "actuator.master_force_rate_limit_n_per_s" [POSITIVE],
        /// Maximum rate of the command to the slave, in the command's unit per s; no limit by default.
        slave_command_rate_per_s: Option<f64> at "actuator.slave_command_rate_limit_per_s" [POSITIVE],
        /// Time constant of the first-order lag of the master's motor; 0: no lag.
        master_lag_s: f64 [NON_NEGATIVE] = 0.0,
        /// Time constant of the first-order lag of the slave's motor; 0: no lag.
        slave_lag_s: f64 [NON_NEGATIVE] = 0.0,
    }
}

impl ActuatorLimits {
    /// Ideal motors.
    pub const NONE: Self = Self::DEFAULT;

    /// True if there is no limit and no lag.
    #[must_use]
    pub fn are_none(&self) -> bool {
        *self == Self::NONE
    }

    /// Maximum `|U_m|` in N, infinite without a limit.
    #[must_use]
    pub fn max_master_force_n(&self) -> f64 {
        self.master_force_n.unwrap_or(f64::INFINITY)
    }

    /// Maximum `|U_s|`, infinite without a limit.
    #[must_use]
    pub fn max_slave_command(&self) -> f64 {
        self.slave_command.unwrap_or(f64::INFINITY)
    }

    /// Maximum change of the commanded `U_m` per tick in N, infinite without a limit.
    #[must_use]
    pub fn max_master_change_n(&self, tick_s: f64) -> f64 {
        self.master_force_rate_n_per_s.map_or(f64::INFINITY, |rate| rate * tick_s)
    }

    /// Maximum change of the commanded `U_s` per tick, infinite without a limit.
    #[must_use]
    pub fn max_slave_change(&self, tick_s: f64) -> f64 {
        self.slave_command_rate_per_s.map_or(f64::INFINITY, |rate| rate * tick_s)
    }
}

/// A motor that follows its held command with a lag, and its effect on the states of its side over a tick.
///
/// `x += from_actual · U_0 + from_command · U_cmd`, then `U_0 ← kept · U_0 + gained · U_cmd`.
#[derive(Debug, Clone, PartialEq)]
pub struct MotorStep<const STATES: usize> {
    /// Effect of the motor's output at the start of the tick.
    pub from_actual: [f64; STATES],
    /// Effect of the command.
    pub from_command: [f64; STATES],
    /// Fraction of the output that remains after a tick.
    pub kept: f64,
    /// Fraction of the command that is reached after a tick.
    pub gained: f64,
}

impl<const STATES: usize> MotorStep<STATES> {
    pub(super) fn new(
        (side, system): (&'static str, &StateSpace<Continuous>),
        input: usize,
        tick_s: f64,
        lag_s: f64,
    ) -> Result<Self, PlantError> {
        let effect = lagged_input(system, input, tick_s, lag_s).map_err(on(side))?;
        let states = system.states();
        let padded = |column: &[f64]| std::array::from_fn(|i| if i < states { column[i] } else { 0.0 });
        Ok(Self {
            from_actual: padded(effect.from_actual.as_slice()),
            from_command: padded(effect.from_command.as_slice()),
            kept: effect.kept,
            gained: effect.gained,
        })
    }
}
