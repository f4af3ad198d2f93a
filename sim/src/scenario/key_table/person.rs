//! The keys of the person's motion.

use trocar_core::settings::{Key, Range as R};

pub(super) const KEYS: &[Key] = &[
    Key::choice(
        "operator.kind",
        &["recording", "ramp", "minimum-jerk", "insertion-extraction", "sine"],
        "recording",
        "Replays the recording's position, moves at a constant speed or with the least jerk, in and out, or swings.",
    ),
    Key::number("operator.start_m", R::ANY, 0.0, "Where a ramp or a movement begins, and the centre of a swing."),
    Key::number("operator.end_m", R::ANY, 0.02, "Where a ramp or a movement ends."),
    Key::number("operator.speed_m_per_s", R::POSITIVE, 0.01, "How fast a ramp gets there."),
    Key::number("operator.movement_s", R::POSITIVE, 1.0, "How long a minimum-jerk movement or an insertion takes."),
    Key::whole("operator.pushes", 1, 1, "In how many pushes, each from rest to rest, an insertion-extraction goes in."),
    Key::number("operator.hold_s", R::NON_NEGATIVE, 1.0, "How long an insertion-extraction rests inside."),
    Key::number("operator.withdrawal_s", R::POSITIVE, 1.0, "How long an insertion-extraction takes to come back."),
    Key::number("operator.amplitude_m", R::ANY, 0.002, "Amplitude of a sine."),
    Key::number("operator.frequency_hz", R::POSITIVE, 1.0, "Frequency of a sine."),
];
