//! The keys of the run itself, and what a scenario adds to the settings of estimator and supervisor.

use trocar_core::settings::{Fallback, Key, Kind, Range as R};

use crate::plant::ControlTiming;
use crate::scenario::engine_kind::EngineKind;

/// Where the estimator's depth begins.
pub(super) const ESTIMATOR_KEYS: &[Key] =
    &[Key::number("estimator.contact_m", R::ANY, 0.0, "Where the estimator takes the tissue to begin.")];

/// What happens without an alarm.
pub(super) const AUGMENTATION_KEYS: &[Key] = &[Key::numbers(
    "augmentation.events_s",
    &[],
    "When the supervisor is alarmed whatever the detector says, as in [1.0, 3.5]; taken where an alarm would be.",
)];

pub(super) const KEYS: &[Key] = &[
    Key::new(
        "name",
        Kind::Text,
        Fallback::Derived("the file's name without its ending"),
        "Names the run's folder and its lines in figures.",
    ),
    // simulation
    Key::number(
        "simulation.tick_s",
        R::POSITIVE,
        1e-3,
        "Time between two ticks. Estimator and detector count samples: their defaults are for 0.5 to 2 ms.",
    ),
    Key::derived(
        "simulation.duration_s",
        R::POSITIVE,
        "the recording's length, or 7 s without one",
        "Length of the run.",
    ),
    EngineKind::KEY,
    ControlTiming::KEY,
    Key::whole("simulation.seed", 0, 1, "Seed of every random number."),
];
