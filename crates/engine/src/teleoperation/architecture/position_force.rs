use super::{Architecture, ArrivedAtMaster, BuiltInArchitecture, MasterGains, MasterSample, SlaveGains};
use crate::teleoperation::{AtMaster, AtSlave, ControllerSettings, Machines};
use trocar_core::error::InvalidValue;
use trocar_core::lane::Lane;
use trocar_core::settings::Key;

/// The paper's: `x_ref = P x_h`, `F_ed = F_e`.
#[derive(Debug, Clone)]
pub struct PositionForce<L> {
    position_scale: L,
}

impl<L: Lane> Architecture<L> for PositionForce<L> {
    #[inline(always)]
    fn slave_target(&mut self, arrived: &MasterSample<L>, _slave: &AtSlave<L>) -> L {
        self.position_scale * arrived.position_m
    }

    #[inline(always)]
    fn master_force(&mut self, arrived: &ArrivedAtMaster<L>, _master: &AtMaster<L>) -> L {
        arrived.force_n
    }
}

impl<L: Lane> BuiltInArchitecture<L> for PositionForce<L> {
    const KEYS: &'static [&'static [Key]] = &[];

    fn gains(_settings: &ControllerSettings, _machines: &Machines) -> Result<(MasterGains, SlaveGains), InvalidValue> {
        Ok((MasterGains { force: 1.0, ..MasterGains::default() }, SlaveGains::default()))
    }

    fn build(_settings: &ControllerSettings, machines: &Machines, _tick_s: f64) -> Result<Self, InvalidValue> {
        Ok(Self { position_scale: L::splat(machines.position_scale) })
    }
}

trocar_core::lane::gather!(PositionForce { position_scale });
