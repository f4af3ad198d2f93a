use super::frozen::FrozenForce;
use super::{Architecture, ArrivedAtMaster, BuiltInArchitecture, MasterGains, MasterSample, SlaveGains};
use crate::teleoperation::{AtMaster, AtSlave, ControllerSettings, Machines};
use trocar_core::error::InvalidValue;
use trocar_core::lane::Lane;
use trocar_core::settings::Key;

trocar_core::settings! {
    /// Slightly stiffer than the arm.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct CouplingSettings in "controller.coupling_" {
        /// Spring between the machines (position-position, four-channel).
        stiffness_n_per_m: f64 [NON_NEGATIVE] = 1000.0,
        /// Damper parallel to the spring.
        damping_n_s_per_m: f64 [NON_NEGATIVE] = 10.0,
    }
}

/// `x_ref = P x_h`, `F_ed = k_x (P x_h - x_e) + k_v (P v_h - v_e)`
#[derive(Debug, Clone)]
pub struct PositionPosition<L> {
    coupling: Coupling<L>,
    frozen: FrozenForce<L>,
}

impl<L: Lane> Architecture<L> for PositionPosition<L> {
    #[inline(always)]
    fn slave_target(&mut self, arrived: &MasterSample<L>, _slave: &AtSlave<L>) -> L {
        self.coupling.position_scale * arrived.position_m
    }

    #[inline(always)]
    fn master_force(&mut self, arrived: &ArrivedAtMaster<L>, master: &AtMaster<L>) -> L {
        let force_n = self.coupling.force_n(arrived, master);
        self.frozen.update(force_n, arrived)
    }
}

impl<L: Lane> BuiltInArchitecture<L> for PositionPosition<L> {
    const COUPLES_POSITIONS: bool = true;
    const KEYS: &'static [&'static [Key]] = &[CouplingSettings::KEYS];

    fn gains(settings: &ControllerSettings, machines: &Machines) -> Result<(MasterGains, SlaveGains), InvalidValue> {
        let position = machines.force_scale * settings.coupling.stiffness_n_per_m;
        let velocity = machines.force_scale * settings.coupling.damping_n_s_per_m;
        Ok((MasterGains { position, velocity, ..MasterGains::default() }, SlaveGains::default()))
    }

    fn build(settings: &ControllerSettings, machines: &Machines, _tick_s: f64) -> Result<Self, InvalidValue> {
        let (at_master, _) = Self::gains(settings, machines)?;
        Ok(Self { coupling: Coupling::new(&at_master, machines), frozen: FrozenForce::default() })
    }
}

#[derive(Debug, Clone)]
pub(super) struct Coupling<L> {
    pub(super) position_scale: L,
    stiffness: L,
    damping: L,
}

impl<L: Lane> Coupling<L> {
    pub(super) fn new(gains: &MasterGains, machines: &Machines) -> Self {
        Self {
            position_scale: L::splat(machines.position_scale),
            stiffness: L::splat(gains.position),
            damping: L::splat(gains.velocity),
        }
    }

    #[inline(always)]
    pub(super) fn force_n(&self, arrived: &ArrivedAtMaster<L>, master: &AtMaster<L>) -> L {
        let offset = self.position_scale * master.position_m - arrived.sample.position_m;
        let rate = self.position_scale * master.velocity_m_per_s - arrived.sample.velocity_m_per_s;
        self.stiffness * offset + self.damping * rate
    }
}

trocar_core::lane::gather!(PositionPosition { coupling, frozen });
trocar_core::lane::gather!(Coupling { position_scale, stiffness, damping });
