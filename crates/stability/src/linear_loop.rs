use super::{Parameter, TissueRange};
use trocar_engine::plant::{
    ActuatorLimits, ArmParameters, ControlTiming, MasterModelSettings, MasterParameters, SlaveParameters,
};
use trocar_engine::teleoperation::LinkSettings;
use trocar_engine::tissue::Relaxation;
use trocar_scenario::{DelayTicks, TissueByDepth, waits_for_tick};

#[derive(Debug, Clone, PartialEq)]
pub struct LinearLoop {
    pub tissue: TissueRange,
    /// At any position scale.
    pub by_depth: Option<TissueByDepth>,
    pub tick_s: f64,
    pub timing: ControlTiming,
    pub master: MasterParameters,
    pub master_model: MasterModelSettings,
    pub arm: ArmParameters,
    pub slave: SlaveParameters,
    /// Only the lags are used.
    pub actuators: ActuatorLimits,
    pub link: LinkSettings,
    /// 0: no lag.
    pub force_bandwidth_hz: f64,
    pub forward_delay_s: f64,
    pub backward_delay_s: f64,
    pub stiffness_n_per_m: f64,
    pub damping_n_s_per_m: f64,
    pub relaxation: Option<Relaxation>,
}

impl LinearLoop {
    pub fn get(&self, parameter: Parameter) -> f64 {
        let mut copy = self.clone();
        *copy.places(parameter)[0]
    }

    /// A position scale changes the tissue's depth; a stiffness or damping replaces the tissue.
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
        match parameter {
            Parameter::Stiffness | Parameter::Damping => other.replace_tissue(),
            Parameter::PositionScale => other.deepen_tissue(),
            _ => {}
        }
        other
    }

    pub(super) fn replace_tissue(&mut self) {
        self.tissue = TissueRange::spring(self.stiffness_n_per_m, self.damping_n_s_per_m);
        (self.by_depth, self.relaxation) = (None, None);
    }

    fn deepen_tissue(&mut self) {
        let range = |tissue: &TissueByDepth| tissue.range(self.link.machines.position_scale);
        let Some(tissue) = self.by_depth.as_ref().and_then(range) else { return };
        let scaled = |value: f64, was: f64, is: f64| if was > 0.0 { value / was * is } else { is };
        let damping = |tissue: &TissueRange| tissue.springs.damping_n_s_per_m.1;
        self.stiffness_n_per_m =
            scaled(self.stiffness_n_per_m, self.tissue.stiffest_n_per_m(), tissue.stiffest_n_per_m());
        self.damping_n_s_per_m = scaled(self.damping_n_s_per_m, damping(&self.tissue), damping(&tissue));
        self.tissue = tissue;
    }

    pub fn forward(&self) -> DelayTicks {
        DelayTicks::new(self.forward_delay_s, self.tick_s, self.waits_for_tick())
    }

    pub fn backward(&self) -> DelayTicks {
        DelayTicks::new(self.backward_delay_s, self.tick_s, self.waits_for_tick())
    }

    pub fn waits_for_tick(&self) -> bool {
        waits_for_tick(self.timing, &self.link, self.has_general_machine())
    }

    pub fn has_general_machine(&self) -> bool {
        self.master_model.is_general() || self.slave.is_general()
    }

    /// True if an additional force acts only through its reading.
    pub fn adds_to_reading(&self) -> bool {
        !self.slave.is_general() && self.link.machines.compliance_m_per_n == 0.0
    }

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
