#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Parameter {
    ForceScale,
    PositionScale,
    Stiffness,
    Damping,
    Delay,
    ForwardDelay,
    BackwardDelay,
    Tick,
    MasterMass,
    MasterDamping,
    ForceIntegralGain,
    ArmKa,
    ArmBa,
    ArmKh,
    ArmBh,
    ArmMass,
    ProportionalGain,
    VelocityGain,
    Compliance,
    CouplingStiffness,
    CouplingDamping,
    MasterForceGain,
    SlaveForceGain,
    AccelerationBandwidth,
    ForceBandwidth,
    MasterLag,
    SlaveLag,
}

const TABLE: [(Parameter, &str, &str); 27] = {
    use Parameter as P;
    [
        (P::ForceScale, "scaling.force", "Force scale"),
        (P::PositionScale, "scaling.position", "Position scale"),
        (P::Stiffness, "tissue.stiffness_n_per_m", "Tissue stiffness (N/m)"),
        (P::Damping, "tissue.damping_n_s_per_m", "Tissue damping (N·s/m)"),
        (P::Delay, "channel.delay_s", "Delay each way (s)"),
        (P::ForwardDelay, "channel.forward_delay_s", "Delay to the slave (s)"),
        (P::BackwardDelay, "channel.backward_delay_s", "Delay to the master (s)"),
        (P::Tick, "simulation.tick_s", "Tick (s)"),
        (P::MasterMass, "master.mass_kg", "Mass of the master (kg)"),
        (P::MasterDamping, "master.damping_n_s_per_m", "Damping of the master (N·s/m)"),
        (P::ForceIntegralGain, "master.force_integral_gain", "Force integral gain (1/s)"),
        (P::ArmKa, "arm.k_a_n_per_m", "k_a of the arm (N/m)"),
        (P::ArmBa, "arm.b_a_n_s_per_m", "b_a of the arm (N·s/m)"),
        (P::ArmKh, "arm.k_h_n_per_m", "k_h of the arm (N/m)"),
        (P::ArmBh, "arm.b_h_n_s_per_m", "b_h of the arm (N·s/m)"),
        (P::ArmMass, "arm.m_h_kg", "m_h of the arm (kg)"),
        (P::ProportionalGain, "slave.proportional_gain", "K_p of the slave"),
        (P::VelocityGain, "slave.velocity_gain", "K_v of the slave"),
        (P::Compliance, "slave.compliance_m_per_n", "Compliance of the slave (m/N)"),
        (P::CouplingStiffness, "controller.coupling_stiffness_n_per_m", "Coupling stiffness (N/m)"),
        (P::CouplingDamping, "controller.coupling_damping_n_s_per_m", "Coupling damping (N·s/m)"),
        (P::MasterForceGain, "controller.master_force_gain", "Local force gain of the master"),
        (P::SlaveForceGain, "controller.slave_force_gain", "Local force gain of the slave"),
        (P::AccelerationBandwidth, "controller.acceleration_bandwidth_hz", "Bandwidth of accelerations (Hz)"),
        (P::ForceBandwidth, "sensor.force_bandwidth_hz", "Bandwidth of the force reading (Hz)"),
        (P::MasterLag, "actuator.master_lag_s", "Lag of the master's motor (s)"),
        (P::SlaveLag, "actuator.slave_lag_s", "Lag of the slave's motor (s)"),
    ]
};

impl Parameter {
    pub fn all() -> impl Iterator<Item = Self> {
        TABLE.iter().map(|(parameter, _, _)| *parameter)
    }

    pub fn of_key(key: &str) -> Option<Self> {
        TABLE.iter().find(|(_, known, _)| *known == key).map(|(parameter, _, _)| *parameter)
    }

    pub fn key(self) -> &'static str {
        TABLE[self as usize].1
    }

    pub fn caption(self) -> &'static str {
        TABLE[self as usize].2
    }

    pub fn varies_with(self, other: Self) -> bool {
        let both_ways = |a: Self, b: Self| a == Self::Delay && matches!(b, Self::ForwardDelay | Self::BackwardDelay);
        self == other || both_ways(self, other) || both_ways(other, self)
    }

    pub fn may_be_zero(self) -> bool {
        !matches!(self, Self::Tick | Self::MasterMass | Self::ArmMass | Self::AccelerationBandwidth)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_is_in_the_order_of_the_parameters() {
        for (index, parameter) in Parameter::all().enumerate() {
            assert_eq!(parameter as usize, index, "{parameter:?}");
            assert_eq!(Parameter::of_key(parameter.key()), Some(parameter));
        }
    }

    #[test]
    fn every_key_except_the_delay_of_both_ways_is_a_scenario_key() {
        for parameter in Parameter::all().filter(|&parameter| parameter != Parameter::Delay) {
            assert!(trocar_scenario::KEYS.iter().any(|key| key.path == parameter.key()), "{}", parameter.key());
        }
    }
}
