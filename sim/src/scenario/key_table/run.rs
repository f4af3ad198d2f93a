//! The keys of the run itself: its name, its ticks, its engine.

use super::key;
use crate::scenario::keys::{Fallback, Key};
use crate::scenario::value::{Kind, Range as R, Value};
use Fallback::Derived;
use Kind::{Choice, Number, Text, Whole};

pub(super) const KEYS: &[Key] = &[
    key(
        "name",
        Text,
        Derived("the file's name without its ending"),
        "Names the run's folder and its lines in figures.",
    ),
    // simulation
    key(
        "simulation.tick_s",
        Number(R::POSITIVE),
        number!(1e-3),
        "Time between two ticks. Estimator and detector count samples: their defaults are for 0.5 to 2 ms.",
    ),
    key(
        "simulation.duration_s",
        Number(R::POSITIVE),
        Derived("the recording's length, or 7 s without one"),
        "Length of the run.",
    ),
    key(
        "simulation.engine",
        Choice(&["exact", "dop853"]),
        word!("exact"),
        "Between ticks: matrix exponentials, or numerical integration as a check.",
    ),
    key(
        "simulation.control",
        Choice(&["continuous", "sampled"]),
        word!("continuous"),
        "Controllers in continuous time, or on the tick with held outputs.",
    ),
    key("simulation.seed", Whole(0), Fallback::Value(|| Value::Whole(1)), "Seed of every random number."),
];
