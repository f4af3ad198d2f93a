//! The keys of the person.

use super::key;
use crate::operator::TremorSettings;
use crate::scenario::keys::{Fallback, Key};
use crate::scenario::value::{Kind, Range as R, Value};
use Kind::{Choice, Number, Whole};

pub(super) const KEYS: &[Key] = &[
    key(
        "operator.kind",
        Choice(&["recording", "ramp", "minimum-jerk", "insertion-extraction", "sine"]),
        word!("recording"),
        "Replays the recording's position, moves at a constant speed or with the least jerk, in and out, or swings.",
    ),
    key(
        "operator.start_m",
        Number(R::ANY),
        number!(0.0),
        "Where a ramp or a movement begins, and the centre of a swing.",
    ),
    key("operator.end_m", Number(R::ANY), number!(0.02), "Where a ramp or a movement ends."),
    key("operator.speed_m_per_s", Number(R::POSITIVE), number!(0.01), "How fast a ramp gets there."),
    key(
        "operator.movement_s",
        Number(R::POSITIVE),
        number!(1.0),
        "How long a minimum-jerk movement or an insertion takes.",
    ),
    key(
        "operator.pushes",
        Whole(1),
        Fallback::Value(|| Value::Whole(1)),
        "In how many pushes, each from rest to rest, an insertion-extraction goes in.",
    ),
    key("operator.hold_s", Number(R::NON_NEGATIVE), number!(1.0), "How long an insertion-extraction rests inside."),
    key(
        "operator.withdrawal_s",
        Number(R::POSITIVE),
        number!(1.0),
        "How long an insertion-extraction takes to come back.",
    ),
    key("operator.amplitude_m", Number(R::ANY), number!(0.002), "Amplitude of a sine."),
    key("operator.frequency_hz", Number(R::POSITIVE), number!(1.0), "Frequency of a sine."),
    key(
        "operator.tremor_amplitude_m",
        Number(R::NON_NEGATIVE),
        number!(TremorSettings::STEADY.amplitude_m),
        "Root mean square of the hand's tremor; usual are tens to hundreds of micrometres.",
    ),
    key(
        "operator.tremor_low_hz",
        Number(R::POSITIVE),
        number!(TremorSettings::STEADY.low_hz),
        "Lower end of the tremor's band.",
    ),
    key(
        "operator.tremor_high_hz",
        Number(R::POSITIVE),
        number!(TremorSettings::STEADY.high_hz),
        "Upper end of the tremor's band.",
    ),
    key(
        "operator.reflex",
        Choice(&["none", "stop", "withdraw"]),
        word!("none"),
        "What the person does, a reaction time after the felt force has fallen: go on, pause, or pause and withdraw.",
    ),
    key(
        "operator.reflex_weber_fraction",
        Number(R::SHARE),
        number!(0.15),
        "By what share of its recent level the felt force has to fall to be noticed.",
    ),
    key("operator.reflex_reaction_min_s", Number(R::NON_NEGATIVE), number!(0.15), "Shortest reaction time."),
    key("operator.reflex_reaction_max_s", Number(R::NON_NEGATIVE), number!(0.25), "Longest reaction time."),
    key("operator.reflex_memory_s", Number(R::POSITIVE), number!(0.05), "Time constant of the recent level."),
    key(
        "operator.reflex_least_force_n",
        Number(R::NON_NEGATIVE),
        number!(0.3),
        "Level below which no fall is noticed.",
    ),
    key("operator.reflex_pause_s", Number(R::NON_NEGATIVE), number!(0.5), "How long the person pauses."),
    key("operator.reflex_withdraw_m", Number(R::NON_NEGATIVE), number!(0.005), "How far they withdraw."),
    key("operator.reflex_withdraw_speed_m_per_s", Number(R::POSITIVE), number!(0.02), "How fast they withdraw."),
];
