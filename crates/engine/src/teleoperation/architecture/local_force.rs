use super::frozen::FrozenForce;
use super::{Architecture, ArrivedAtMaster, BuiltInArchitecture, MasterGains, MasterSample, SlaveGains};
use crate::teleoperation::{AtMaster, AtSlave, ControllerSettings, Machines};
use trocar_core::error::{InvalidValue, require};
use trocar_core::lane::Lane;
use trocar_core::settings::Key;

trocar_core::settings! {
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct LocalForceSettings in "controller." {
        /// C_6, local force feedback at the master (local-force, four-channel): divides its apparent mass by 1 + C_6.
        master_force_gain: f64 [NON_NEGATIVE] = 6.0,
        /// C_5, local force feedback at the slave (local-force, four-channel), in command U_s per N: makes the slave
        /// compliant.
        slave_force_gain: f64 [NON_NEGATIVE] = 0.0,
    }
}

/// `x_ref = P x_h - g_e f_e`, `F_ed = k_f F_e - k_h F_h`
#[derive(Debug, Clone)]
pub struct LocalForce<L> {
    position_scale: L,
    local_force: L,
    load: HandLoad<L>,
    frozen: FrozenForce<L>,
}

impl<L: Lane> Architecture<L> for LocalForce<L> {
    #[inline(always)]
    fn slave_target(&mut self, arrived: &MasterSample<L>, slave: &AtSlave<L>) -> L {
        self.position_scale * arrived.position_m - self.local_force * slave.force_n
    }

    #[inline(always)]
    fn master_force(&mut self, arrived: &ArrivedAtMaster<L>, master: &AtMaster<L>) -> L {
        let force_n = self.load.force_n(arrived, master);
        self.frozen.update(force_n, arrived)
    }
}

impl<L: Lane> BuiltInArchitecture<L> for LocalForce<L> {
    const KEYS: &'static [&'static [Key]] = &[LocalForceSettings::KEYS];

    fn gains(settings: &ControllerSettings, machines: &Machines) -> Result<(MasterGains, SlaveGains), InvalidValue> {
        let (k_p, settings) = (machines.proportional_gain, &settings.local_force);
        require("slave.proportional_gain", k_p, k_p > 0.0, "above 0 for this controller.kind")?;
        let (force, hand) = (1.0 + settings.master_force_gain, settings.master_force_gain);
        let local_force = settings.slave_force_gain / k_p;
        Ok((MasterGains { force, hand, ..MasterGains::default() }, SlaveGains { local_force, ..SlaveGains::default() }))
    }

    fn build(settings: &ControllerSettings, machines: &Machines, _tick_s: f64) -> Result<Self, InvalidValue> {
        let (at_master, at_slave) = Self::gains(settings, machines)?;
        Ok(Self {
            position_scale: L::splat(machines.position_scale),
            local_force: L::splat(at_slave.local_force),
            load: HandLoad::new(&at_master),
            frozen: FrozenForce::default(),
        })
    }
}

#[derive(Debug, Clone)]
pub(super) struct HandLoad<L> {
    force: L,
    hand: L,
}

impl<L: Lane> HandLoad<L> {
    pub(super) fn new(gains: &MasterGains) -> Self {
        Self { force: L::splat(gains.force), hand: L::splat(gains.hand) }
    }

    #[inline(always)]
    pub(super) fn force_n(&self, arrived: &ArrivedAtMaster<L>, master: &AtMaster<L>) -> L {
        self.force * arrived.force_n - self.hand * master.hand_force_n
    }
}

trocar_core::lane::gather!(LocalForce { position_scale, local_force, load, frozen });
trocar_core::lane::gather!(HandLoad { force, hand });
