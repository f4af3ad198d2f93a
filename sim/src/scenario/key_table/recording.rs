//! The keys of the recording that is replayed or detected in.

use trocar_core::settings::{Constant, Fallback, Key, Kind, Range as R};

use crate::recording::Limits;

const LIMITS: Limits = Limits::DEFAULT;

pub(super) const KEYS: &[Key] = &[
    Key::new(
        "recording.file",
        Kind::File,
        Fallback::Unset,
        "A CSV file, or builtin:in_vivo_like.csv, builtin:own_ctrl_pop.csv.",
    ),
    Key::numbers("recording.ruptures_s", &[], "When layers rupture, counted from the recording's first sample."),
    Key::sign("recording.force_sign", 1.0, "-1 where the file counts resistance to insertion as negative."),
    Key::sign("recording.position_sign", 1.0, "-1 where the file's positions shrink into the tissue."),
    Key::new(
        "recording.velocity_sign",
        Kind::Sign,
        Fallback::Derived("that of the position"),
        "-1 where the file's velocities are negative into the tissue.",
    ),
    Key::optional(
        "recording.max_gap_s",
        R::POSITIVE,
        "Longest time between two samples; 10 median intervals when not given.",
    ),
    Key::whole("recording.max_bytes", 1, LIMITS.max_bytes, "Largest file that is read."),
    Key::whole("recording.max_samples", 2, LIMITS.max_samples as u64, "Most samples that are kept."),
    Key::new("recording.columns.time_s", Kind::Text, Fallback::Value(Constant::Text("time_s")), "Time."),
    Key::new(
        "recording.columns.position_m",
        Kind::Text,
        Fallback::Value(Constant::Text("position_m")),
        "Position of the needle.",
    ),
    Key::new(
        "recording.columns.velocity_m_per_s",
        Kind::Text,
        Fallback::Unset,
        "Velocity of the needle; estimated from the position when not given.",
    ),
    Key::new(
        "recording.columns.force_n",
        Kind::Text,
        Fallback::Value(Constant::Text("force_n")),
        "Force on the needle.",
    ),
    Key::number("recording.scale.time_s", R::POSITIVE, 1.0, "To seconds."),
    Key::number(
        "recording.scale.position_m",
        R::POSITIVE,
        1.0,
        "To metres, as 0.075 for the angle of a lever of that length.",
    ),
    Key::number("recording.scale.velocity_m_per_s", R::POSITIVE, 1.0, "To metres per second."),
    Key::number("recording.scale.force_n", R::POSITIVE, 1.0, "To newtons."),
];
