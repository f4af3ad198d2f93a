use super::accelerometer::Accelerometer;
use super::frozen::FrozenForce;
use super::local_force::{HandLoad, LocalForce};
use super::position_position::{Coupling, PositionPosition};
use super::{Architecture, ArrivedAtMaster, BuiltInArchitecture, MasterGains, MasterSample, SlaveGains, SlaveSample};
use crate::teleoperation::{AtMaster, AtSlave, ControllerSettings, CouplingSettings, LocalForceSettings, Machines};
use trocar_core::error::InvalidValue;
use trocar_core::lane::Lane;
use trocar_core::settings::Key;

trocar_core::settings! {
    /// With all defaults, the transmitted stiffness of a 50 N/m tissue is within 5 % at 5 Hz, and the loop is stable at
    /// 4000 N/m in a firm grip (`tests/it/architectures.rs`).
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct FourChannelSettings in "controller." {
        /// Bandwidth of the acceleration estimates (four-channel).
        acceleration_bandwidth_hz: f64 [POSITIVE] = 100.0,
    }
}

#[derive(Debug, Clone)]
pub struct FourChannel<L> {
    load: HandLoad<L>,
    coupling: Coupling<L>,
    drag: L,
    inertia: L,
    velocity: L,
    acceleration: L,
    hand_force: L,
    local_force: L,
    at_master: Accelerometer<L>,
    at_slave: Accelerometer<L>,
    frozen: FrozenForce<L>,
}

impl<L: Lane> Architecture<L> for FourChannel<L> {
    #[inline(always)]
    fn master_sends(&mut self, master: &AtMaster<L>) -> MasterSample<L> {
        MasterSample {
            position_m: master.position_m,
            velocity_m_per_s: master.velocity_m_per_s,
            acceleration_m_per_s2: self.at_master.update(master.velocity_m_per_s),
            hand_force_n: master.hand_force_n,
        }
    }

    #[inline(always)]
    fn slave_target(&mut self, arrived: &MasterSample<L>, slave: &AtSlave<L>) -> L {
        self.coupling.position_scale * arrived.position_m
            + (self.velocity * arrived.velocity_m_per_s + self.acceleration * arrived.acceleration_m_per_s2)
            + (self.hand_force * arrived.hand_force_n - self.local_force * slave.force_n)
    }

    #[inline(always)]
    fn slave_sends(&mut self, slave: &AtSlave<L>, force_n: L) -> SlaveSample<L> {
        let acceleration_m_per_s2 = self.at_slave.update(slave.velocity_m_per_s);
        SlaveSample { acceleration_m_per_s2, ..SlaveSample::without_acceleration(slave, force_n) }
    }

    #[inline(always)]
    fn master_force(&mut self, arrived: &ArrivedAtMaster<L>, master: &AtMaster<L>) -> L {
        let SlaveSample { velocity_m_per_s, acceleration_m_per_s2, .. } = arrived.sample;
        let force_n = self.load.force_n(arrived, master) + self.coupling.force_n(arrived, master)
            - (self.drag * velocity_m_per_s + self.inertia * acceleration_m_per_s2);
        self.frozen.update(force_n, arrived)
    }
}

impl<L: Lane> BuiltInArchitecture<L> for FourChannel<L> {
    const COUPLES_POSITIONS: bool = true;
    const MODELS_SLAVE: bool = true;
    const KEYS: &'static [&'static [Key]] =
        &[CouplingSettings::KEYS, LocalForceSettings::KEYS, FourChannelSettings::KEYS];

    /// Lawrence's `C_1 = Z_s + C_s`, `C_2 = 1 + C_6`, `C_3 = 1 + C_5`, `C_4 = -(Z_m + C_m)`; the slave's compliance
    /// reduces `C_3`.
    fn gains(settings: &ControllerSettings, machines: &Machines) -> Result<(MasterGains, SlaveGains), InvalidValue> {
        let Machines { position_scale, force_scale, proportional_gain: k_p, .. } = *machines;
        let (load, local) = LocalForce::<L>::gains(settings, machines)?;
        let (coupling, _) = PositionPosition::<L>::gains(settings, machines)?;
        let at_master = MasterGains {
            position: coupling.position,
            velocity: coupling.velocity,
            drag: machines.master_damping_n_s_per_m / position_scale,
            inertia: machines.master_mass_kg / position_scale,
            ..load
        };
        let at_slave = SlaveGains {
            velocity: position_scale * (machines.velocity_gain + machines.slave_drag) / k_p,
            acceleration: position_scale * machines.slave_inertia / k_p,
            hand_force: (local.local_force + machines.compliance_m_per_n) / force_scale,
            ..local
        };
        Ok((at_master, at_slave))
    }

    fn build(settings: &ControllerSettings, machines: &Machines, tick_s: f64) -> Result<Self, InvalidValue> {
        let (at_master, at_slave) = Self::gains(settings, machines)?;
        let accelerometer = Accelerometer::new(settings.four_channel.acceleration_bandwidth_hz, tick_s);
        Ok(Self {
            load: HandLoad::new(&at_master),
            coupling: Coupling::new(&at_master, machines),
            drag: L::splat(at_master.drag),
            inertia: L::splat(at_master.inertia),
            velocity: L::splat(at_slave.velocity),
            acceleration: L::splat(at_slave.acceleration),
            hand_force: L::splat(at_slave.hand_force),
            local_force: L::splat(at_slave.local_force),
            at_master: accelerometer.clone(),
            at_slave: accelerometer,
            frozen: FrozenForce::default(),
        })
    }
}

trocar_core::lane::gather!(FourChannel {
    load,
    coupling,
    drag,
    inertia,
    velocity,
    acceleration,
    hand_force,
    local_force,
    at_master,
    at_slave,
    frozen,
});
