//! What the motors of both sides can do.

use super::{PlantError, on};
use crate::lti::{Continuous, StateSpace, lagged_input};

trocar_core::settings! {
    /// Limits on what the motors make of the controllers' commands, the same either way; `None` is without a limit, a lag of 0
    /// none.
    ///
    /// A wanted command is clipped to the range, then goes there from the last one no faster than its rate; held until the
    /// next tick, it is followed with the lag in continuous time.
    ///
    /// All of it acts on the held output of a controller that runs on the tick
    /// ([`ControlTiming::Sampled`](super::ControlTiming)): when a continuous one would saturate between ticks is not known
    /// beforehand, so that no exact step exists.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct ActuatorLimits in "actuator." {
        /// Greatest force U_m of the master's motor, either way; without a limit when not given.
        master_force_n: Option<f64> at "actuator.master_force_limit_n" [POSITIVE],
        /// Greatest command U_s to the slave, either way, in its own unit; without a limit when not given.
        slave_command: Option<f64> at "actuator.slave_command_limit" [POSITIVE],
        /// How fast the commanded force of the master's motor changes at most; without a limit when not given.
        master_force_rate_n_per_s: Option<f64> at "actuator.master_force_rate_limit_n_per_s" [POSITIVE],
        /// How fast the command to the slave changes at most, in its unit per s; without a limit when not given.
        slave_command_rate_per_s: Option<f64> at "actuator.slave_command_rate_limit_per_s" [POSITIVE],
        /// Time constant with which the master's motor follows its command, first-order; 0: no lag.
        master_lag_s: f64 [NON_NEGATIVE] = 0.0,
        /// Time constant with which the slave's motor follows its command, first-order; 0: no lag.
        slave_lag_s: f64 [NON_NEGATIVE] = 0.0,
    }
}

impl ActuatorLimits {
    /// Motors that do what they are told.
    pub const NONE: Self = Self::DEFAULT;

    /// Whether nothing is limited and nothing lags.
    #[must_use]
    pub fn are_none(&self) -> bool {
        *self == Self::NONE
    }

    /// Greatest `|U_m|` in N, infinite without a limit.
    #[must_use]
    pub fn max_master_force_n(&self) -> f64 {
        self.master_force_n.unwrap_or(f64::INFINITY)
    }

    /// Greatest `|U_s|`, infinite without a limit.
    #[must_use]
    pub fn max_slave_command(&self) -> f64 {
        self.slave_command.unwrap_or(f64::INFINITY)
    }

    /// Greatest change of the commanded `U_m` in N from one tick to the next, infinite without a limit.
    #[must_use]
    pub fn max_master_change_n(&self, tick_s: f64) -> f64 {
        self.master_force_rate_n_per_s.map_or(f64::INFINITY, |rate| rate * tick_s)
    }

    /// Greatest change of the commanded `U_s` from one tick to the next, infinite without a limit.
    #[must_use]
    pub fn max_slave_change(&self, tick_s: f64) -> f64 {
        self.slave_command_rate_per_s.map_or(f64::INFINITY, |rate| rate * tick_s)
    }
}

/// What a motor that lags behind its held command does over a tick, to itself and to the states of its side.
///
/// `x += from_actual · U_0 + from_command · U_cmd`, then `U_0 ← kept · U_0 + gained · U_cmd`.
#[derive(Debug, Clone, PartialEq)]
pub struct MotorStep<const STATES: usize> {
    /// Effect of what the motor does at the start of the tick.
    pub from_actual: [f64; STATES],
    /// Effect of its command.
    pub from_command: [f64; STATES],
    /// Share of what it did that is left at the end.
    pub kept: f64,
    /// Share of its command that it has then reached.
    pub gained: f64,
}

impl<const STATES: usize> MotorStep<STATES> {
    /// The motor at input `input` of a side without its controller; states beyond the side's own are left alone.
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
