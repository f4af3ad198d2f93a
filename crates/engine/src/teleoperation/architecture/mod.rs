mod accelerometer;
pub(super) mod four_channel;
mod frozen;
mod gains;
pub(super) mod local_force;
mod position_force;
pub(super) mod position_position;

pub use gains::{MasterGains, SlaveGains};

use self::four_channel::FourChannelSettings;
use self::local_force::LocalForceSettings;
use self::position_position::CouplingSettings;
use trocar_core::settings::{ActsFor, Key};

use super::Machines;
use super::connection::{AtMaster, AtSlave};
use trocar_core::augmentation::Modes;
use trocar_core::error::InvalidValue;
use trocar_core::lane::Lane;

#[derive(Debug, Clone, Copy)]
pub struct MasterSample<L> {
    pub position_m: L,
    pub velocity_m_per_s: L,
    pub acceleration_m_per_s2: L,
    pub hand_force_n: L,
}

#[derive(Debug, Clone, Copy)]
pub struct SlaveSample<L> {
    /// Scaled to the master.
    pub force_n: L,
    pub position_m: L,
    pub velocity_m_per_s: L,
    pub acceleration_m_per_s2: L,
}

impl<L: Lane> SlaveSample<L> {
    #[inline(always)]
    pub fn without_acceleration(slave: &AtSlave<L>, force_n: L) -> Self {
        Self {
            force_n,
            position_m: slave.position_m,
            velocity_m_per_s: slave.velocity_m_per_s,
            acceleration_m_per_s2: L::zero(),
        }
    }
}

#[derive(Debug, Clone, Copy)]
pub struct ArrivedAtMaster<L> {
    pub sample: SlaveSample<L>,
    /// Force of the sample, or the passivity scheme's replacement.
    pub force_n: L,
    pub mode: Modes<L>,
}

pub trait Architecture<L: Lane> {
    #[inline(always)]
    fn master_sends(&mut self, master: &AtMaster<L>) -> MasterSample<L> {
        MasterSample {
            position_m: master.position_m,
            velocity_m_per_s: master.velocity_m_per_s,
            acceleration_m_per_s2: L::zero(),
            hand_force_n: master.hand_force_n,
        }
    }

    fn slave_target(&mut self, arrived: &MasterSample<L>, slave: &AtSlave<L>) -> L;

    #[inline(always)]
    fn slave_sends(&mut self, slave: &AtSlave<L>, force_n: L) -> SlaveSample<L> {
        SlaveSample::without_acceleration(slave, force_n)
    }

    /// While the slave is frozen, the position coupling must keep its value: the force would grow as the hand moves
    /// away.
    fn master_force(&mut self, arrived: &ArrivedAtMaster<L>, master: &AtMaster<L>) -> L;
}

impl<L: Lane, T: Architecture<L> + ?Sized> Architecture<L> for Box<T> {
    fn master_sends(&mut self, master: &AtMaster<L>) -> MasterSample<L> {
        (**self).master_sends(master)
    }

    fn slave_target(&mut self, arrived: &MasterSample<L>, slave: &AtSlave<L>) -> L {
        (**self).slave_target(arrived, slave)
    }

    fn slave_sends(&mut self, slave: &AtSlave<L>, force_n: L) -> SlaveSample<L> {
        (**self).slave_sends(slave, force_n)
    }

    fn master_force(&mut self, arrived: &ArrivedAtMaster<L>, master: &AtMaster<L>) -> L {
        (**self).master_force(arrived, master)
    }
}

pub(super) trait BuiltInArchitecture<L: Lane>: Architecture<L> + Sized {
    const COUPLES_POSITIONS: bool = false;
    const MODELS_SLAVE: bool = false;
    const KEYS: &'static [&'static [Key]];

    fn gains(settings: &ControllerSettings, machines: &Machines) -> Result<(MasterGains, SlaveGains), InvalidValue>;

    fn build(settings: &ControllerSettings, machines: &Machines, tick_s: f64) -> Result<Self, InvalidValue>;
}

trocar_core::registry! {
    /// Architecture: the paper's; the same with local force feedback; a spring between the machines; or the transparent
    /// four-channel architecture (Lawrence 1993).
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    pub enum ControllerKind at "controller.kind" = PositionForce;
    pub enum AnyArchitecture<L> by (each, of_kind);

    "position-force" => PositionForce = position_force::PositionForce,
    "local-force" => LocalForce = local_force::LocalForce,
    "position-position" => PositionPosition = position_position::PositionPosition,
    "four-channel" => FourChannel = four_channel::FourChannel,
}

trocar_core::settings! {
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct ControllerSettings in "controller." {
        kind: ControllerKind,
        coupling: CouplingSettings for (ControllerKind::measurement(CouplingSettings::KEYS)),
        local_force: LocalForceSettings for (ControllerKind::measurement(LocalForceSettings::KEYS)),
        four_channel: FourChannelSettings for (ControllerKind::measurement(FourChannelSettings::KEYS)),
    }
}

impl ControllerKind {
    const fn measurement(keys: &[Key]) -> ActsFor {
        let kinds = of_kind!([WORD, Part] => (WORD, <Part<f64> as BuiltInArchitecture<f64>>::KEYS));
        ActsFor::built_from(keys, Self::KEY.path, &kinds)
    }

    pub fn couples_positions(self) -> bool {
        of_kind!(self, Part => Part::<f64>::COUPLES_POSITIONS)
    }

    /// True if the gains depend on [`Machines::slave_drag`] and [`Machines::slave_inertia`].
    pub fn models_slave(self) -> bool {
        of_kind!(self, Part => Part::<f64>::MODELS_SLAVE)
    }
}

impl ControllerSettings {
    pub fn gains(&self, machines: &Machines) -> Result<(MasterGains, SlaveGains), InvalidValue> {
        of_kind!(self.kind, Part => Part::<f64>::gains(self, machines))
    }
}

impl<L: Lane> AnyArchitecture<L> {
    pub(in crate::teleoperation) fn new(
        settings: &ControllerSettings,
        machines: &Machines,
        tick_s: f64,
    ) -> Result<Self, InvalidValue> {
        of_kind!(settings.kind, Part => Part::<L>::build(settings, machines, tick_s).map(Self::from))
    }
}

impl<L: Lane> Architecture<L> for AnyArchitecture<L> {
    #[inline(always)]
    fn master_sends(&mut self, master: &AtMaster<L>) -> MasterSample<L> {
        each!(self, architecture => architecture.master_sends(master))
    }

    #[inline(always)]
    fn slave_target(&mut self, arrived: &MasterSample<L>, slave: &AtSlave<L>) -> L {
        each!(self, architecture => architecture.slave_target(arrived, slave))
    }

    #[inline(always)]
    fn slave_sends(&mut self, slave: &AtSlave<L>, force_n: L) -> SlaveSample<L> {
        each!(self, architecture => architecture.slave_sends(slave, force_n))
    }

    #[inline(always)]
    fn master_force(&mut self, arrived: &ArrivedAtMaster<L>, master: &AtMaster<L>) -> L {
        each!(self, architecture => architecture.master_force(arrived, master))
    }
}

#[cfg(test)]
mod tests;
