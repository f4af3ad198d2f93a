use super::recovery::RecoverySettings;
use super::{AnyArchitecture, ControllerKind, ControllerSettings, PassivitySettings, Scheme};
use trocar_core::error::InvalidValue;
use trocar_core::lane::Lane;

trocar_core::settings! {
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct Scales in "scaling." {
        /// Feedback force per measured force.
        force: f64 [SCALE] = 1.0,
        /// Slave motion per master motion.
        position: f64 [SCALE] = 1.0,
    }
}

trocar_core::settings! {
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct ComplianceSettings in "slave." {
        /// Static deflection of the slave under the tissue force; the paper's slave is stiff.
        compliance_m_per_n: f64 [NON_NEGATIVE] = 0.0,
    }
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LinkSettings {
    pub controller: ControllerSettings,
    pub machines: Machines,
    pub recovery: RecoverySettings,
    pub passivity: PassivitySettings,
}

impl LinkSettings {
    pub fn check(&self, tick_s: f64) -> Result<(), InvalidValue> {
        self.architecture::<f64>(tick_s).map(drop)
    }

    pub(super) fn architecture<L: Lane>(&self, tick_s: f64) -> Result<AnyArchitecture<L>, InvalidValue> {
        self.controller.validate()?;
        self.recovery.validate()?;
        self.passivity.validate()?;
        AnyArchitecture::new(&self.controller, &self.machines, tick_s)
    }

    pub fn forwards_samples(&self) -> bool {
        self.controller.kind == ControllerKind::PositionForce && self.passivity.scheme == Scheme::None
    }

    pub fn is_baseline(&self) -> bool {
        self.forwards_samples() && self.machines.compliance_m_per_n == 0.0
    }
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Machines {
    pub master_mass_kg: f64,
    pub master_damping_n_s_per_m: f64,
    /// `K_p`.
    pub proportional_gain: f64,
    /// `K_v`.
    pub velocity_gain: f64,
    /// `U_s` per m/s of a slow motion.
    pub slave_drag: f64,
    /// `U_s` per m/s² of a slow motion.
    pub slave_inertia: f64,
    pub compliance_m_per_n: f64,
    pub position_scale: f64,
    pub force_scale: f64,
}

impl Machines {
    pub const UNCOUPLED: Self = Self {
        master_mass_kg: 0.0,
        master_damping_n_s_per_m: 0.0,
        proportional_gain: 0.0,
        velocity_gain: 0.0,
        slave_drag: 0.0,
        slave_inertia: 0.0,
        compliance_m_per_n: 0.0,
        position_scale: 1.0,
        force_scale: 1.0,
    };

    /// A position scale of 0 leaves no common energy.
    pub fn energy_scale(&self) -> f64 {
        if self.position_scale == 0.0 { 1.0 } else { self.force_scale / self.position_scale }
    }
}
