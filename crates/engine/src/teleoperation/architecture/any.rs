//! The list of the built-in architectures.

use trocar_core::settings::{ActsFor, Key};

use super::super::connection::{AtMaster, AtSlave};
use super::super::settings::Machines;
use super::four_channel::FourChannelSettings;
use super::local_force::LocalForceSettings;
use super::position_position::CouplingSettings;
use super::{Architecture, ArrivedAtMaster, BuiltInArchitecture, MasterGains, MasterSample, SlaveGains, SlaveSample};
use super::{four_channel, local_force, position_force, position_position};
use trocar_core::error::InvalidValue;
use trocar_core::lane::Lane;

trocar_core::registry! {
    /// The paper's architecture; the same with local force feedback; a spring between the machines; or four-channel,
    /// transparent (Lawrence 1993).
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    pub enum ControllerKind at "controller.kind" = PositionForce;
    /// A built-in architecture.
    pub enum AnyArchitecture<L> by (each, of_kind);

    "position-force" => PositionForce = position_force::PositionForce,
    "local-force" => LocalForce = local_force::LocalForce,
    "position-position" => PositionPosition = position_position::PositionPosition,
    "four-channel" => FourChannel = four_channel::FourChannel,
}

trocar_core::settings! {
    /// The kind of architecture, and the settings of all kinds: a key acts for the kinds that read it.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct ControllerSettings in "controller." {
        /// The kind.
        kind: ControllerKind,
        /// The spring between the machines.
        coupling: CouplingSettings for (ControllerKind::reading(CouplingSettings::KEYS)),
        /// The local force feedback.
        local_force: LocalForceSettings for (ControllerKind::reading(LocalForceSettings::KEYS)),
        /// The four channels.
        four_channel: FourChannelSettings for (ControllerKind::reading(FourChannelSettings::KEYS)),
    }
}

impl ControllerKind {
    /// The kinds that read these keys.
    const fn reading(keys: &[Key]) -> ActsFor {
        let kinds = of_kind!([WORD, Part] => (WORD, <Part<f64> as BuiltInArchitecture<f64>>::KEYS));
        ActsFor::built_from(keys, Self::KEY.path, &kinds)
    }

    /// Whether the feedback force depends on both machines' positions, so that the slave sends its position.
    #[must_use]
    pub fn couples_positions(self) -> bool {
        of_kind!(self, Part => Part::<f64>::COUPLES_POSITIONS)
    }

    /// Whether the gains depend on the slave's dynamics ([`Machines::slave_drag`] and [`Machines::slave_inertia`]).
    #[must_use]
    pub fn models_slave(self) -> bool {
        of_kind!(self, Part => Part::<f64>::MODELS_SLAVE)
    }
}

impl ControllerSettings {
    /// The gains for two machines.
    ///
    /// # Errors
    /// [`InvalidValue`] if the law divides by `K_p` and `K_p` is 0.
    pub fn gains(&self, machines: &Machines) -> Result<(MasterGains, SlaveGains), InvalidValue> {
        of_kind!(self.kind, Part => Part::<f64>::gains(self, machines))
    }
}

impl<L: Lane> AnyArchitecture<L> {
    /// The chosen architecture, with a tick of `tick_s` (s).
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
