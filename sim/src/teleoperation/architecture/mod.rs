//! The architectures: what each side sends, and what it makes of what the other has sent.

mod accelerometer;
pub(super) mod four_channel;
mod frozen;
mod gains;
pub(super) mod local_force;
pub(super) mod position_force;
pub(super) mod position_position;

pub use gains::{MasterGains, SlaveGains};

use trocar_core::settings::Key;

use super::connection::{AtMaster, AtSlave};
use super::{ControllerSettings, Machines};
use crate::error::InvalidValue;
use crate::lane::Lane;

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

/// What the master has of the slave at a tick.
#[derive(Debug, Clone, Copy)]
pub struct ArrivedAtMaster<L> {
    /// What was sent.
    pub sample: SlaveSample<L>,
    /// The sample's force in N, or what the passivity scheme has put in its place.
    pub force_n: L,
    /// The slave's mode: 0 teleoperation, 1 augmented (the slave is frozen), 2 re-engaging.
    pub mode: L,
}

/// What each side sends and makes of what arrives.
pub trait Architecture<L: Lane> {
    /// What the master sends; without acceleration where nothing is said.
    #[inline(always)]
    fn master_sends(&mut self, master: &AtMaster<L>) -> MasterSample<L> {
        MasterSample {
            position_m: master.position_m,
            velocity_m_per_s: master.velocity_m_per_s,
            acceleration_m_per_s2: L::zero(),
            hand_force_n: master.hand_force_n,
        }
    }

    /// The target for the slave's reference in m, in the slave's metres.
    fn slave_target(&mut self, arrived: &MasterSample<L>, slave: &AtSlave<L>) -> L;

    /// What the slave sends, where the measured force is `force_n` (N) scaled to the master; without acceleration where
    /// nothing is said.
    #[inline(always)]
    fn slave_sends(&mut self, slave: &AtSlave<L>, force_n: L) -> SlaveSample<L> {
        SlaveSample::without_acceleration(slave, force_n)
    }

    /// The force to feed back in N.
    ///
    /// While the slave is frozen, what couples the positions has to stay as it was: the hand must not feel how far it has
    /// moved away from a needle that is held.
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

/// What a line in the registry needs of an architecture besides: the linear law that it is, for the analysis of stability,
/// and how it is built.
pub(super) trait BuiltInArchitecture<L: Lane>: Architecture<L> + Sized {
    /// Whether the force depends on where both machines are.
    const COUPLES_POSITIONS: bool = false;
    /// Whether the gains follow from how the slave moves.
    const MODELS_SLAVE: bool = false;
    /// The groups of keys that it is built from.
    const KEYS: &'static [&'static [Key]];

    /// The gains around two machines.
    fn gains(settings: &ControllerSettings, machines: &Machines) -> Result<(MasterGains, SlaveGains), InvalidValue>;

    /// The architecture at rest, on ticks of `tick_s` (s).
    fn build(settings: &ControllerSettings, machines: &Machines, tick_s: f64) -> Result<Self, InvalidValue>;
}
