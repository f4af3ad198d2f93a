//! The settings of a tissue in a functional mock-up unit, and the errors of a unit that does not fit them.

use super::fmu::{FmuError, UnitTissue};

trocar_core::settings! {
    /// Settings of a tissue in a functional mock-up unit.
    #[derive(Debug, Clone, PartialEq)]
    pub struct FmuSettings in "tissue.fmu." no const {
        /// Functional mock-up unit of the tissue: FMI 2.0 or 3.0, co-simulation. A run executes its code, so use only
        /// trusted units.
        file: Option<String> [FILE],
        /// Communication step, a whole number of ticks. The force is held between the steps.
        step_s: Option<f64> [POSITIVE] => "simulation.tick_s",
        /// Name of the input for the needle's position, in m, increasing into the tissue.
        position: String = "needle.position_m",
        /// Name of the input for the needle's velocity, in m/s; by default needle.velocity_m_per_s, if the unit has
        /// that input.
        velocity: Option<String>,
        /// Name of the output with the force on the needle, in N, positive when it resists insertion.
        force: String = "reaction.force_n",
        /// Name of the output that becomes true, or changes from 0 to another number, when a layer ruptures; by default
        /// reaction.ruptured, if the unit has that output. Without it no rupture is known.
        ruptured: Option<String>,
        /// Values of the unit's parameters, as in "stiffness = 300; damping = 4", in the units of the parameters; true
        /// is 1.
        parameters: Option<String>,
    }
}

/// A setting that does not fit its unit.
#[derive(Debug, Clone, PartialEq)]
pub struct UnfitUnit {
    /// Key of the setting.
    pub key: &'static str,
    /// Problem of the setting.
    pub problem: UnitProblem,
}

/// Problem of a setting of a unit.
#[derive(Debug, Clone, PartialEq)]
pub enum UnitProblem {
    /// The unit itself, or one of its variables.
    Unit(FmuError),
    /// The setting, as a sentence that follows the key.
    Setting(String),
}

impl UnitTissue {
    /// Key of the unit's file.
    #[must_use]
    pub fn file_key() -> &'static str {
        FmuSettings::KEYS[0].path
    }

    /// Key of the communication step.
    #[must_use]
    pub fn step_key() -> &'static str {
        FmuSettings::KEYS[1].path
    }
}
