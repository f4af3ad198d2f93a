//! What the analysis takes for the tissue of a scenario.

use crate::scenario::{Scenario, TissueSpec};
use crate::tissue::TissueSettings;

/// Whether the tissue reacts to the needle, as a closed loop needs it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TissueKind {
    /// The spring and damper of the analysis.
    SpringDamper,
    /// A model or a recording by depth, which the analysis replaces by springs of its range of stiffness.
    Other,
    /// A force recorded over time, which does not depend on the needle.
    RecordedForce,
}

impl TissueKind {
    /// The kind of a scenario's tissue.
    #[must_use]
    pub fn of(scenario: &Scenario) -> Self {
        match (&scenario.tissue, scenario.tissue.settings()) {
            (TissueSpec::Recording { .. }, _) => Self::RecordedForce,
            (_, Some(TissueSettings::KelvinVoigt(_))) => Self::SpringDamper,
            (TissueSpec::Depth { .. } | TissueSpec::Model(_) | TissueSpec::Unit(_), _) => Self::Other,
        }
    }
}
