//! What a link is told besides its two directions.

use super::recovery::RecoverySettings;
use super::{ControllerKind, ControllerSettings, PassivitySettings, Scheme};

trocar_core::settings! {
    /// What a newton and a metre become on the other side.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct Scales in "scaling." {
        /// Force fed back per force measured.
        force: f64 [SCALE] = 1.0,
        /// Slave's motion per master's.
        position: f64 [SCALE] = 1.0,
    }
}

trocar_core::settings! {
    /// How stiff the slave is under the tissue.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct ComplianceSettings in "slave." {
        /// How far the tissue pushes the resting slave off its reference; the paper's is stiff.
        compliance_m_per_n: f64 [NON_NEGATIVE] = 0.0,
    }
}

/// Everything that a link is told but its two directions.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LinkSettings {
    /// The architecture.
    pub controller: ControllerSettings,
    /// What its gains depend on.
    pub machines: Machines,
    /// What happens after an outage.
    pub recovery: RecoverySettings,
    /// What keeps it passive.
    pub passivity: PassivitySettings,
}

impl LinkSettings {
    /// Whether it is the paper's: position and force sent and taken as they are.
    #[must_use]
    pub fn is_baseline(&self) -> bool {
        self.controller.kind == ControllerKind::PositionForce
            && self.passivity.scheme == Scheme::None
            && self.machines.compliance_m_per_n == 0.0
    }
}

/// What the gains of an architecture depend on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Machines {
    /// Mass of the master in kg.
    pub master_mass_kg: f64,
    /// Its damping in N·s/m.
    pub master_damping_n_s_per_m: f64,
    /// `K_p` of the slave.
    pub proportional_gain: f64,
    /// `K_v` of the slave.
    pub velocity_gain: f64,
    /// Command `U_s` that a slow motion of the slave takes per m/s.
    pub slave_drag: f64,
    /// And per m/s².
    pub slave_inertia: f64,
    /// How far the tissue pushes the resting slave off its reference, in m/N.
    pub compliance_m_per_n: f64,
    /// Slave's motion per master's.
    pub position_scale: f64,
    /// Force fed back per force measured.
    pub force_scale: f64,
}
