//! Settings of a link besides its two lines.

use super::recovery::RecoverySettings;
use super::{AnyArchitecture, ControllerKind, ControllerSettings, PassivitySettings, Scheme};
use trocar_core::error::InvalidValue;
use trocar_core::lane::Lane;

trocar_core::settings! {
    /// Scale factors between the two sides.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct Scales in "scaling." {
        /// Feedback force per measured force.
        force: f64 [SCALE] = 1.0,
        /// Slave motion per master motion.
        position: f64 [SCALE] = 1.0,
    }
}

trocar_core::settings! {
    /// The slave's compliance.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct ComplianceSettings in "slave." {
        /// Static deflection of the slave under the tissue force; the paper's slave is stiff.
        compliance_m_per_n: f64 [NON_NEGATIVE] = 0.0,
    }
}

/// All settings of a link except its two lines.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LinkSettings {
    /// Architecture.
    pub controller: ControllerSettings,
    /// Properties of the machines that the gains depend on.
    pub machines: Machines,
    /// Recovery after an outage.
    pub recovery: RecoverySettings,
    /// Passivity scheme.
    pub passivity: PassivitySettings,
}

impl LinkSettings {
    /// Checks the settings for a link on ticks of `tick_s`.
    ///
    /// # Errors
    /// [`InvalidValue`] naming the first setting out of range.
    pub fn check(&self, tick_s: f64) -> Result<(), InvalidValue> {
        self.architecture::<f64>(tick_s).map(drop)
    }

    pub(super) fn architecture<L: Lane>(&self, tick_s: f64) -> Result<AnyArchitecture<L>, InvalidValue> {
        self.controller.validate()?;
        self.recovery.validate()?;
        self.passivity.validate()?;
        AnyArchitecture::new(&self.controller, &self.machines, tick_s)
    }

    /// True if no architecture and no passivity scheme changes position and force.
    #[must_use]
    pub fn forwards_samples(&self) -> bool {
        self.controller.kind == ControllerKind::PositionForce && self.passivity.scheme == Scheme::None
    }

    /// Returns true for the paper's link: unchanged position and force, and a slave without compliance.
    #[must_use]
    pub fn is_baseline(&self) -> bool {
        self.forwards_samples() && self.machines.compliance_m_per_n == 0.0
    }
}

/// Properties of the machines that the gains of an architecture depend on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Machines {
    /// Mass of the master in kg.
    pub master_mass_kg: f64,
    /// Damping of the master in N·s/m.
    pub master_damping_n_s_per_m: f64,
    /// `K_p` of the slave.
    pub proportional_gain: f64,
    /// `K_v` of the slave.
    pub velocity_gain: f64,
    /// Command `U_s` per m/s of a slow motion of the slave.
    pub slave_drag: f64,
    /// Command `U_s` per m/s² of a slow motion of the slave.
    pub slave_inertia: f64,
    /// Static deflection of the slave under the tissue force, in m/N.
    pub compliance_m_per_n: f64,
    /// Slave motion per master motion.
    pub position_scale: f64,
    /// Feedback force per measured force.
    pub force_scale: f64,
}

impl Machines {
    /// Machines without mass and gains, and with scales of 1.
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

    /// Energy at the master per energy at the slave: force scale over position scale, 1 for an open loop.
    ///
    /// If a scale of 0 opens the loop, there is no common energy.
    #[must_use]
    pub fn energy_scale(&self) -> f64 {
        if self.position_scale == 0.0 { 1.0 } else { self.force_scale / self.position_scale }
    }
}
