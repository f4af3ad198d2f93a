//! The keys of the recording that is replayed or detected in.

use super::key;
use crate::recording::Limits;
use crate::scenario::keys::{Fallback, Key};
use crate::scenario::value::{Kind, Range as R, Value};
use Fallback::{Derived, Unset};
use Kind::{File, Number, Numbers, Sign, Text, Whole};

pub(super) const KEYS: &[Key] = &[
    key("recording.file", File, Unset, "A CSV file, or builtin:in_vivo_like.csv, builtin:own_ctrl_pop.csv."),
    key(
        "recording.ruptures_s",
        Numbers,
        Fallback::Value(|| Value::Numbers(vec![])),
        "When layers rupture, counted from the recording's first sample.",
    ),
    key("recording.force_sign", Sign, number!(1.0), "-1 where the file counts resistance to insertion as negative."),
    key("recording.position_sign", Sign, number!(1.0), "-1 where the file's positions shrink into the tissue."),
    key(
        "recording.velocity_sign",
        Sign,
        Derived("that of the position"),
        "-1 where the file's velocities are negative into the tissue.",
    ),
    key(
        "recording.max_gap_s",
        Number(R::POSITIVE),
        Unset,
        "Longest time between two samples; 10 median intervals when not given.",
    ),
    key(
        "recording.max_bytes",
        Whole(1),
        Fallback::Value(|| Value::Whole(Limits::default().max_bytes)),
        "Largest file that is read.",
    ),
    key(
        "recording.max_samples",
        Whole(2),
        Fallback::Value(|| Value::Whole(Limits::default().max_samples as u64)),
        "Most samples that are kept.",
    ),
    key("recording.columns.time_s", Text, word!("time_s"), "Time."),
    key("recording.columns.position_m", Text, word!("position_m"), "Position of the needle."),
    key(
        "recording.columns.velocity_m_per_s",
        Text,
        Unset,
        "Velocity of the needle; estimated from the position when not given.",
    ),
    key("recording.columns.force_n", Text, word!("force_n"), "Force on the needle."),
    key("recording.scale.time_s", Number(R::POSITIVE), number!(1.0), "To seconds."),
    key(
        "recording.scale.position_m",
        Number(R::POSITIVE),
        number!(1.0),
        "To metres, as 0.075 for the angle of a lever of that length.",
    ),
    key("recording.scale.velocity_m_per_s", Number(R::POSITIVE), number!(1.0), "To metres per second."),
    key("recording.scale.force_n", Number(R::POSITIVE), number!(1.0), "To newtons."),
];
