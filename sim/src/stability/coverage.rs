//! What the linear loop leaves out of a scenario.

use std::fmt::{self, Display, Formatter};

use crate::augmentation::{AugmentationSettings, ForceLawSettings, HoldSettings, Reengage};
use crate::plant::ActuatorLimits;
use crate::scenario::{Scenario, TissueSpec};
use crate::teleoperation::Scheme;
use crate::tissue::TissueSettings;

/// A part of a scenario that the linear loop leaves out.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct LeftOut {
    /// The key that switches it on.
    pub key: &'static str,
    /// What it is.
    pub what: &'static str,
}

/// Returns the parts of a scenario that the linear loop leaves out, besides tissue and augmentation, which have their
/// own analyses. With any of them the stability of the scenario is unknown.
#[must_use]
pub fn left_out(scenario: &Scenario) -> Vec<LeftOut> {
    let ActuatorLimits { master_force_n, master_force_rate_n_per_s, slave_command, slave_command_rate_per_s, .. } =
        scenario.actuators;
    let irregularity = &scenario.irregularity;
    let (forward, backward) = (&scenario.forward_schedule, &scenario.backward_schedule);
    let varies = [forward, backward].iter().any(|schedule| schedule.has_delays() && schedule.constant().is_none());
    let sensor = &scenario.sensor;
    let AugmentationSettings { enabled, hold, reengage, force, .. } = scenario.augmentation;
    let (is_held, stops) = (hold == HoldSettings::Frozen, matches!(reengage, Reengage::RampUntilLoad { .. }));
    let damps = matches!(force, ForceLawSettings::Damp(_));
    let parts = [
        (enabled && !is_held, "augmentation.hold", "a hold other than a freeze"),
        (enabled && stops, "augmentation.reengage", "a ramp that stops under load"),
        (enabled && damps, "augmentation.force_law", "the added damping"),
        (scenario.link.passivity.scheme != Scheme::None, "passivity.scheme", "the passivity scheme"),
        (master_force_n.is_some(), "actuator.master_force_limit_n", "the limit of the master's force"),
        (
            master_force_rate_n_per_s.is_some(),
            "actuator.master_force_rate_limit_n_per_s",
            "the rate limit of its force",
        ),
        (slave_command.is_some(), "actuator.slave_command_limit", "the limit of the slave's command"),
        (
            slave_command_rate_per_s.is_some(),
            "actuator.slave_command_rate_limit_per_s",
            "the rate limit of its command",
        ),
        (irregularity.jitter_s > 0.0, "channel.jitter_s", "jitter"),
        (irregularity.loss > 0.0, "channel.loss", "lost samples"),
        (forward.has_outages() || backward.has_outages(), "channel.outages_s", "outages"),
        (varies, "channel.delays_file", "delays that vary"),
        (scenario.organ_motion.breathing_amplitude_m > 0.0, "tissue.breathing_amplitude_m", "breathing"),
        (scenario.organ_motion.heartbeat_amplitude_m > 0.0, "tissue.heartbeat_amplitude_m", "the heartbeat"),
        (scenario.reflex.reacts(), "operator.reflex", "the operator's reflex"),
        (scenario.stretch.acts(), "operator.stretch_short_gain_n_s_per_m", "the stretch reflexes"),
        (scenario.stiffening.acts(), "operator.stiffening_per_n", "the grip that stiffens"),
        (sensor.position_resolution_m > 0.0, "sensor.position_resolution_m", "the steps of the position sensor"),
        (sensor.force_resolution_n > 0.0, "sensor.force_resolution_n", "the steps of the force sensor"),
        (sensor.force_range_n.is_some(), "sensor.force_range_n", "the range of the force sensor"),
    ];
    parts.into_iter().filter(|(is_there, ..)| *is_there).map(|(_, key, what)| LeftOut { key, what }).collect()
}

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

impl Display for LeftOut {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        write!(f, "{} ({})", self.what, self.key)
    }
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

/// Everything that the linear loop leaves out of a scenario, with tissue and augmentation.
#[must_use]
pub fn unmodelled(scenario: &Scenario) -> Vec<String> {
    let tissue = match TissueKind::of(scenario) {
        TissueKind::SpringDamper => "lost contact",
        TissueKind::Other => "the tissue (replaced by a spring), its ruptures and friction, and lost contact",
        TissueKind::RecordedForce => "the recorded force (replaced by a spring and a damper)",
    };
    let augmentation =
        scenario.augmentation.enabled.then(|| "the augmentation (see the switching analysis)".to_owned());
    let others = left_out(scenario).into_iter().map(|part| part.to_string());
    std::iter::once(tissue.to_owned()).chain(augmentation).chain(others).collect()
}
