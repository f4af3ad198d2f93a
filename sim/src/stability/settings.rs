//! The linearised loop: the parameters of a scenario on which its stability depends.

use super::Parameter;
use crate::channel::Schedule;
use crate::plant::{ActuatorLimits, ArmParameters, ControlTiming, MasterParameters, SlaveParameters};
use crate::scenario::{Constant, DelayTicks, Fallback, Key, Scenario, Value, find_key, waits_for_tick};
use crate::teleoperation::{LinkSettings, PassivitySettings};

/// A loop in permanent contact with `f_e = K x_e + B v_e`.
#[derive(Debug, Clone, PartialEq)]
pub struct LoopSettings {
    /// Time between two ticks in s.
    pub tick_s: f64,
    /// In continuous time or on the tick.
    pub timing: ControlTiming,
    /// The master.
    pub master: MasterParameters,
    /// The arm.
    pub arm: ArmParameters,
    /// The slave.
    pub slave: SlaveParameters,
    /// The motors; only their lags are used.
    pub actuators: ActuatorLimits,
    /// Architecture, scales and compliance.
    pub link: LinkSettings,
    /// First-order bandwidth of the force reading in Hz; 0: no lag.
    pub force_bandwidth_hz: f64,
    /// Delay from master to slave, in s.
    pub forward_delay_s: f64,
    /// Delay from slave to master, in s.
    pub backward_delay_s: f64,
    /// `K` in N/m.
    pub stiffness_n_per_m: f64,
    /// `B` in N·s/m.
    pub damping_n_s_per_m: f64,
}

impl LoopSettings {
    /// The loop of a scenario. `K` and `B` are those of its `tissue.stiffness_n_per_m` and `tissue.damping_n_s_per_m`, for
    /// every kind of tissue; where these keys do not act, their defaults, 200 N/m and 5 N·s/m. Delays from a file that
    /// vary are the shortest of them, as jitter is on top of a delay ([`VaryingDelays`](super::VaryingDelays)).
    #[must_use]
    pub fn of(scenario: &Scenario) -> Self {
        let values = scenario.values();
        let acts = |path| find_key(path).is_some_and(|key| values.is_acting(key));
        let number = |path| match values.get(path) {
            Some(Value::Number(number)) => *number,
            _ => 0.0,
        };
        let tissue = |path| match find_key(path) {
            Some(Key { fallback: Fallback::Value(Constant::Number(default)), .. }) if !acts(path) => *default,
            _ => number(path),
        };
        let delay_s = |schedule: &Schedule, key| {
            schedule.ages().map_or_else(|| number(key), |(shortest, _)| scenario.grid.time_s(shortest))
        };
        Self {
            tick_s: scenario.grid.tick_s(),
            timing: scenario.timing,
            master: scenario.master,
            arm: scenario.arm,
            slave: scenario.slave.clone(),
            actuators: ActuatorLimits {
                master_lag_s: scenario.actuators.master_lag_s,
                slave_lag_s: scenario.actuators.slave_lag_s,
                ..ActuatorLimits::NONE
            },
            link: LinkSettings { passivity: PassivitySettings::DEFAULT, ..scenario.link },
            force_bandwidth_hz: scenario.sensor.force_bandwidth_hz,
            forward_delay_s: delay_s(&scenario.forward_schedule, "channel.forward_delay_s"),
            backward_delay_s: delay_s(&scenario.backward_schedule, "channel.backward_delay_s"),
            stiffness_n_per_m: tissue("tissue.stiffness_n_per_m"),
            damping_n_s_per_m: tissue("tissue.damping_n_s_per_m"),
        }
    }

    /// The value of a parameter.
    #[must_use]
    pub fn get(&self, parameter: Parameter) -> f64 {
        let mut copy = self.clone();
        *copy.places(parameter)[0]
    }

    /// This loop with another value of a parameter; dependent gains are updated.
    #[must_use]
    pub fn with(&self, parameter: Parameter, value: f64) -> Self {
        let mut other = self.clone();
        for place in other.places(parameter) {
            *place = value;
        }
        let machines = &mut other.link.machines;
        machines.master_mass_kg = other.master.mass_kg;
        machines.master_damping_n_s_per_m = other.master.damping_n_s_per_m;
        machines.proportional_gain = other.slave.proportional_gain;
        machines.velocity_gain = other.slave.velocity_gain;
        other
    }

    /// The delay from master to slave, as the receiver reads it.
    #[must_use]
    pub fn forward(&self) -> DelayTicks {
        DelayTicks::new(self.forward_delay_s, self.tick_s, self.waits_for_tick())
    }

    /// The delay from slave to master, as the receiver reads it.
    #[must_use]
    pub fn backward(&self) -> DelayTicks {
        DelayTicks::new(self.backward_delay_s, self.tick_s, self.waits_for_tick())
    }

    /// Whether a sample that arrives within a tick is read at the next one.
    #[must_use]
    pub fn waits_for_tick(&self) -> bool {
        waits_for_tick(self.timing, &self.link)
    }

    /// The fields that hold a parameter.
    fn places(&mut self, parameter: Parameter) -> Vec<&mut f64> {
        use Parameter as P;
        let machines = &mut self.link.machines;
        let controller = &mut self.link.controller;
        vec![match parameter {
            P::Delay => return vec![&mut self.forward_delay_s, &mut self.backward_delay_s],
            P::ForceScale => &mut machines.force_scale,
            P::PositionScale => &mut machines.position_scale,
            P::Compliance => &mut machines.compliance_m_per_n,
            P::Stiffness => &mut self.stiffness_n_per_m,
            P::Damping => &mut self.damping_n_s_per_m,
            P::ForwardDelay => &mut self.forward_delay_s,
            P::BackwardDelay => &mut self.backward_delay_s,
            P::Tick => &mut self.tick_s,
            P::MasterMass => &mut self.master.mass_kg,
            P::MasterDamping => &mut self.master.damping_n_s_per_m,
            P::ForceIntegralGain => &mut self.master.force_integral_gain,
            P::ArmKa => &mut self.arm.k_a_n_per_m,
            P::ArmBa => &mut self.arm.b_a_n_s_per_m,
            P::ArmKh => &mut self.arm.k_h_n_per_m,
            P::ArmBh => &mut self.arm.b_h_n_s_per_m,
            P::ArmMass => &mut self.arm.m_h_kg,
            P::ProportionalGain => &mut self.slave.proportional_gain,
            P::VelocityGain => &mut self.slave.velocity_gain,
            P::CouplingStiffness => &mut controller.coupling.stiffness_n_per_m,
            P::CouplingDamping => &mut controller.coupling.damping_n_s_per_m,
            P::MasterForceGain => &mut controller.local_force.master_force_gain,
            P::SlaveForceGain => &mut controller.local_force.slave_force_gain,
            P::AccelerationBandwidth => &mut controller.four_channel.acceleration_bandwidth_hz,
            P::ForceBandwidth => &mut self.force_bandwidth_hz,
            P::MasterLag => &mut self.actuators.master_lag_s,
            P::SlaveLag => &mut self.actuators.slave_lag_s,
        }]
    }
}
