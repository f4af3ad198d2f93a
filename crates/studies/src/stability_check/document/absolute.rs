//! Absolute stability with bounded hands and tissues.

use std::fmt::Write as _;

use serde_json::{Value as Json, json};

use trocar_document::{DataTable, Values, significant};
use trocar_scenario::unit_of;
use trocar_stability::{AbsoluteOver, AbsolutePoint, Analysis, Bounded, Terminations, arm_impedance};

fn finite(value: f64) -> Option<f64> {
    Some(value).filter(|value| value.is_finite())
}

/// A range in words, or its only value.
fn range((low, high): (f64, f64), unit: &str) -> String {
    if low == high {
        format!("{} {unit}", significant(low))
    } else {
        format!("{} to {} {unit}", significant(low), significant(high))
    }
}

/// The damping of a hand that is needed with the tissues of the range at each frequency, and that of the scenario's arm.
pub(super) fn hand_damping(analysis: &Analysis, bounded: &Bounded) -> DataTable<'static> {
    let needed = &bounded.needed;
    let arm = |hertz: f64| arm_impedance(&analysis.settings.arm, hertz).re;
    DataTable::new("hand_damping")
        .numbers("frequency_hz", needed.iter().map(|point| point.frequency_hz))
        .numbers("needed_n_s_per_m", needed.iter().map(|point| point.damping_n_s_per_m))
        .numbers("arm_n_s_per_m", needed.iter().map(|point| arm(point.frequency_hz)))
}

/// A line about the hands and tissues of the ranges; empty without a two-port.
pub(super) fn bounded_line(analysis: &Analysis, bounded: &Bounded) -> String {
    let (Some(most), Some(needed), Some(is_stable)) = (bounded.most(), bounded.needed_damping(), bounded.is_stable())
    else {
        return String::new();
    };
    let Terminations { hand_n_s_per_m: (low, high), stiffness_n_per_m, damping_n_s_per_m } = bounded.terminations;
    let (stiffness, damping) = (range(stiffness_n_per_m, "N/m"), range(damping_n_s_per_m, "N·s/m"));
    let mut text = format!("with tissues of {stiffness} and {damping}: ");
    let at = format!("{} Hz", significant(most.frequency_hz));
    let below = if high.is_finite() { format!(" and at most {} N·s/m", significant(high)) } else { String::new() };
    let arm = significant(arm_impedance(&analysis.settings.arm, most.frequency_hz).re);
    text += &match needed {
        needed if needed.is_infinite() => format!("no damping of the hand is enough{below} (at {at})"),
        0.0 => format!("stable with every passive hand{below}"),
        needed => format!(
            "stable with every hand of at least {} N·s/m{below} (at {at}, where the scenario's arm has {arm} N·s/m)",
            significant(needed)
        ),
    };
    if low > 0.0 {
        let _ = write!(text, "; of at least {} N·s/m: {}", significant(low), if is_stable { "yes" } else { "no" });
    }
    text
}

/// Returns the bounded hands and tissues for `stability.json`. What is infinite is `null`.
pub(super) fn bounded_json(analysis: &Analysis, bounded: &Bounded) -> Json {
    let Terminations { hand_n_s_per_m: (low, high), stiffness_n_per_m, damping_n_s_per_m } = bounded.terminations;
    let most = bounded.most();
    json!({
        "hand_n_s_per_m": [low, finite(high)],
        "stiffness_n_per_m": stiffness_n_per_m,
        "damping_n_s_per_m": damping_n_s_per_m,
        "is_stable": bounded.is_stable(),
        "needed_hand_damping_n_s_per_m": bounded.needed_damping().and_then(finite),
        "frequency_hz": most.map(|most| most.frequency_hz),
        "arm_damping_n_s_per_m": most.map(|most| arm_impedance(&analysis.settings.arm, most.frequency_hz).re),
    })
}

/// The absolute stability over a parameter. A needed damping of `inf` is more than any.
pub(super) fn table(absolute: &AbsoluteOver) -> DataTable<'static> {
    let points = &absolute.points;
    let bounded = || points.iter().map(|point| &point.bounded);
    DataTable::new("absolute")
        .numbers(absolute.parameter.key(), points.iter().map(|point| point.value))
        .optional("min_llewellyn", points.iter().map(|point| finite(point.min_llewellyn)))
        .flags("is_absolutely_stable", points.iter().map(|point| point.is_absolutely_stable))
        .optional("needed_hand_damping_n_s_per_m", bounded().map(Bounded::needed_damping))
        .optional("frequency_hz", bounded().map(|bounded| bounded.most().map(|most| most.frequency_hz)))
        .with("is_stable_with_ranges", Values::Flags(bounded().map(Bounded::is_stable).collect()))
}

/// Returns the absolute stability over a parameter for `stability.json`.
pub(super) fn json(absolute: &AbsoluteOver) -> Json {
    let points = absolute.points.iter().map(|point| {
        let bounded = &point.bounded;
        json!({
            "value": point.value,
            "min_llewellyn": finite(point.min_llewellyn),
            "is_absolutely_stable": point.is_absolutely_stable,
            "needed_hand_damping_n_s_per_m": bounded.needed_damping().and_then(finite),
            "frequency_hz": bounded.most().map(|most| most.frequency_hz),
            "is_stable_with_ranges": bounded.is_stable(),
        })
    });
    json!({ "parameter": absolute.parameter.key(), "points": points.collect::<Vec<_>>() })
}

/// A line about the absolute stability over a parameter: up to which value it holds.
pub(super) fn line(absolute: &AbsoluteOver) -> String {
    let key = absolute.parameter.key();
    let unit = unit_of(key).map_or(String::new(), |unit| format!(" {unit}"));
    let up_to = |holds: &dyn Fn(&AbsolutePoint) -> bool| {
        let last = absolute.points.iter().take_while(|point| holds(point)).last();
        last.map_or("not at the first value".to_owned(), |point| format!("up to {}{unit}", significant(point.value)))
    };
    format!(
        "stable over {key}: with any passive hand and tissue {}, with those of the ranges {}",
        up_to(&|point| point.is_absolutely_stable),
        up_to(&|point| point.bounded.is_stable() == Some(true)),
    )
}
