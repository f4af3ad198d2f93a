//! The architectures: what each side sends, and how it uses what it receives.

mod accelerometer;
mod any;
pub(super) mod four_channel;
mod frozen;
mod gains;
pub(super) mod local_force;
mod position_force;
pub(super) mod position_position;

pub use any::{AnyArchitecture, ControllerKind, ControllerSettings};
pub use gains::{MasterGains, SlaveGains};

use trocar_core::settings::Key;

use super::Machines;
use super::connection::{AtMaster, AtSlave};
use trocar_core::augmentation::Modes;
use trocar_core::error::InvalidValue;
use trocar_core::lane::Lane;

/// What the master sends.
#[derive(Debug, Clone, Copy)]
pub struct MasterSample<L> {
    /// `x_h` in m.
    pub position_m: L,
    /// `v_h` in m/s.
    pub velocity_m_per_s: L,
    /// `a_h` in m/s².
    pub acceleration_m_per_s2: L,
    /// `F_h` in N.
    pub hand_force_n: L,
}

/// What the slave sends.
#[derive(Debug, Clone, Copy)]
pub struct SlaveSample<L> {
    /// The measured force scaled to the master, in N.
    pub force_n: L,
    /// `x_e` in m.
    pub position_m: L,
    /// `v_e` in m/s.
    pub velocity_m_per_s: L,
    /// `a_e` in m/s².
    pub acceleration_m_per_s2: L,
}

impl<L: Lane> SlaveSample<L> {
    /// The slave's state with a force in N scaled to the master; its acceleration is 0.
    #[inline(always)]
    #[must_use]
    pub fn without_acceleration(slave: &AtSlave<L>, force_n: L) -> Self {
        Self {
            force_n,
            position_m: slave.position_m,
            velocity_m_per_s: slave.velocity_m_per_s,
            acceleration_m_per_s2: L::zero(),
        }
    }
}

/// What the master's side receives at a tick.
#[derive(Debug, Clone, Copy)]
pub struct ArrivedAtMaster<L> {
    /// The received sample.
    pub sample: SlaveSample<L>,
    /// The sample's force in N, or the passivity scheme's replacement.
    pub force_n: L,
    /// The slave's mode.
    pub mode: Modes<L>,
}

/// What each side sends, and how it uses what it receives.
pub trait Architecture<L: Lane> {
    /// What the master sends. The default sends an acceleration of 0.
    #[inline(always)]
    fn master_sends(&mut self, master: &AtMaster<L>) -> MasterSample<L> {
        MasterSample {
            position_m: master.position_m,
            velocity_m_per_s: master.velocity_m_per_s,
            acceleration_m_per_s2: L::zero(),
            hand_force_n: master.hand_force_n,
        }
    }

    /// The target of the slave's reference in m, on the slave's scale.
    fn slave_target(&mut self, arrived: &MasterSample<L>, slave: &AtSlave<L>) -> L;

    /// What the slave sends, given the measured force scaled to the master (`force_n`, N). The default sends an
    /// acceleration of 0.
    #[inline(always)]
    fn slave_sends(&mut self, slave: &AtSlave<L>, force_n: L) -> SlaveSample<L> {
        SlaveSample::without_acceleration(slave, force_n)
    }

    /// The feedback force in N.
    ///
    /// While the slave is frozen, the position coupling keeps its value: otherwise the feedback force would grow as the
    /// hand moves away from the held needle.
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

/// What the registry needs of an architecture besides the trait: its linear law, for the stability analysis, and a
/// constructor.
pub(super) trait BuiltInArchitecture<L: Lane>: Architecture<L> + Sized {
    /// Whether the feedback force depends on both machines' positions.
    const COUPLES_POSITIONS: bool = false;
    /// Whether the gains depend on the slave's dynamics.
    const MODELS_SLAVE: bool = false;
    /// The groups of keys that it reads.
    const KEYS: &'static [&'static [Key]];

    /// The gains for two machines.
    fn gains(settings: &ControllerSettings, machines: &Machines) -> Result<(MasterGains, SlaveGains), InvalidValue>;

    /// The architecture at rest, with a tick of `tick_s` (s).
    fn build(settings: &ControllerSettings, machines: &Machines, tick_s: f64) -> Result<Self, InvalidValue>;
}

#[cfg(test)]
mod tests;
