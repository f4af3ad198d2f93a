use super::{PlantError, on};
use trocar_lti::{Continuous, StateSpace, lagged_input};

trocar_core::settings! {
    /// On the tick: with a continuous controller no exact step would exist.
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
    pub const NONE: Self = Self::DEFAULT;

    pub fn are_none(&self) -> bool {
        *self == Self::NONE
    }

    pub fn max_master_force_n(&self) -> f64 {
        self.master_force_n.unwrap_or(f64::INFINITY)
    }

    pub fn max_slave_command(&self) -> f64 {
        self.slave_command.unwrap_or(f64::INFINITY)
    }

    pub fn max_master_change_n(&self, tick_s: f64) -> f64 {
        self.master_force_rate_n_per_s.map_or(f64::INFINITY, |rate| rate * tick_s)
    }

    pub fn max_slave_change(&self, tick_s: f64) -> f64 {
        self.slave_command_rate_per_s.map_or(f64::INFINITY, |rate| rate * tick_s)
    }
}

/// `x += from_actual · U_0 + from_command · U_cmd`, then `U_0 ← kept · U_0 + gained · U_cmd`.
#[derive(Debug, Clone, PartialEq)]
pub struct MotorStep<const STATES: usize> {
    pub from_actual: [f64; STATES],
    pub from_command: [f64; STATES],
    pub kept: f64,
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
