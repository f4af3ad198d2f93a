//! The keys of what happens on a detection.

use super::key;
use crate::augmentation::{AugmentationSettings, ForceLawSettings, Reengage};
use crate::scenario::keys::{Fallback, Key};
use crate::scenario::value::{Kind, Range as R, Value};
use Kind::{Choice, Flag, Number, Numbers};

pub(super) const KEYS: &[Key] = &[
    key(
        "augmentation.enabled",
        Flag,
        Fallback::Value(|| Value::Flag(AugmentationSettings::default().enabled)),
        "false: the classical scheme.",
    ),
    key(
        "augmentation.freeze",
        Choice(&["measured", "reference"]),
        word!("measured"),
        "Hold the slave at its measured position or at its last reference.",
    ),
    key(
        "augmentation.reengage",
        Choice(&["ramp", "clutch", "snap"]),
        word!("ramp"),
        "Close the gap to the hand at a bounded speed, keep it, or jump it.",
    ),
    key(
        "augmentation.catch_up_speed_m_per_s",
        Number(R::POSITIVE),
        number!(default_catch_up_speed()),
        "Speed at which a ramp closes the gap, on top of the hand's.",
    ),
    key(
        "augmentation.force_law",
        Choice(&["decay", "amplify"]),
        word!("decay"),
        "Let the felt force decay, or scale its variation.",
    ),
    key(
        "augmentation.decay_ratio",
        Number(R::SHARE),
        number!(default_decay().0),
        "Where decay ends, as a share of the force at the alarm.",
    ),
    key("augmentation.decay_time_constant_s", Number(R::POSITIVE), number!(default_decay().1), "How fast it decays."),
    key("augmentation.amplification", Number(R::AT_LEAST_ONE), number!(2.0), "kappa of amplify."),
    key(
        "augmentation.blend_s",
        Number(R::NON_NEGATIVE),
        number!(AugmentationSettings::default().blend_s),
        "Length of the cross-fade back to the measured force.",
    ),
    key(
        "augmentation.min_hold_s",
        Number(R::NON_NEGATIVE),
        number!(AugmentationSettings::default().automaton.min_hold_s),
        "Shortest freeze.",
    ),
    key(
        "augmentation.max_hold_s",
        Number(R::NON_NEGATIVE),
        number!(AugmentationSettings::default().automaton.max_hold_s),
        "Longest freeze.",
    ),
    key(
        "augmentation.exit_ratio",
        Number(R::POSITIVE_SHARE),
        number!(AugmentationSettings::default().automaton.exit_ratio),
        "Share of the threshold below which g counts as quiet.",
    ),
    key(
        "augmentation.exit_quiet_s",
        Number(R::NON_NEGATIVE),
        number!(AugmentationSettings::default().automaton.exit_quiet_s),
        "How long g has to be quiet before release.",
    ),
    key(
        "augmentation.refractory_s",
        Number(R::NON_NEGATIVE),
        number!(AugmentationSettings::default().automaton.refractory_s),
        "How long after an event no alarm is taken.",
    ),
    key(
        "augmentation.events_s",
        Numbers,
        Fallback::Value(|| Value::Numbers(vec![])),
        "When the supervisor is alarmed whatever the detector says, as in [1.0, 3.5]; taken where an alarm would be.",
    ),
];

fn default_catch_up_speed() -> f64 {
    match Reengage::default() {
        Reengage::Ramp { catch_up_speed_m_per_s } => catch_up_speed_m_per_s,
        Reengage::Clutch | Reengage::Snap => 0.03,
    }
}

fn default_decay() -> (f64, f64) {
    match ForceLawSettings::default() {
        ForceLawSettings::Decay { ratio, time_constant_s } => (ratio, time_constant_s),
        ForceLawSettings::Amplify { .. } => (0.0, 0.03),
    }
}
