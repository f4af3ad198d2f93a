use std::fmt::Write as _;

use schemars::JsonSchema;
use serde::Serialize;

use trocar_document::{DataTable, Values, significant};
use trocar_scenario::unit_of;
use trocar_stability::{AbsoluteOver, AbsolutePoint, Analysis, Bounded, Terminations, arm_impedance};

fn finite(value: f64) -> Option<f64> {
    Some(value).filter(|value| value.is_finite())
}

fn range((low, high): (f64, f64), unit: &str) -> String {
    if low == high {
        format!("{} {unit}", significant(low))
    } else {
        format!("{} to {} {unit}", significant(low), significant(high))
    }
}

pub(super) fn hand_damping(analysis: &Analysis, bounded: &Bounded) -> DataTable<'static> {
    let needed = &bounded.needed;
    let arm = |hertz: f64| arm_impedance(&analysis.settings.arm, hertz).re;
    DataTable::new("hand_damping")
        .numbers("frequency_hz", needed.iter().map(|point| point.frequency_hz))
        .numbers("needed_n_s_per_m", needed.iter().map(|point| point.damping_n_s_per_m))
        .numbers("arm_n_s_per_m", needed.iter().map(|point| arm(point.frequency_hz)))
}

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

/// Absolute stability with bounded hands and tissues. An infinite value is `None`.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct BoundedPart {
    /// Minimum and maximum damping of the hand, in N·s/m.
    hand_n_s_per_m: (f64, Option<f64>),
    /// Minimum and maximum stiffness of the tissue, in N/m.
    stiffness_n_per_m: (f64, f64),
    /// Minimum and maximum damping of the tissue, in N·s/m.
    damping_n_s_per_m: (f64, f64),
    /// True if the loop is stable with every hand and tissue of these ranges.
    is_stable: Option<bool>,
    /// The needed damping of the hand, in N·s/m.
    needed_hand_damping_n_s_per_m: Option<f64>,
    /// The frequency at which this damping is needed, in Hz.
    frequency_hz: Option<f64>,
    /// The damping of the scenario's arm at this frequency, in N·s/m.
    arm_damping_n_s_per_m: Option<f64>,
}

impl BoundedPart {
    pub(super) fn of(analysis: &Analysis, bounded: &Bounded) -> Self {
        let Terminations { hand_n_s_per_m: (low, high), stiffness_n_per_m, damping_n_s_per_m } = bounded.terminations;
        let frequency_hz = bounded.most().map(|most| most.frequency_hz);
        Self {
            hand_n_s_per_m: (low, finite(high)),
            stiffness_n_per_m,
            damping_n_s_per_m,
            is_stable: bounded.is_stable(),
            needed_hand_damping_n_s_per_m: bounded.needed_damping().and_then(finite),
            frequency_hz,
            arm_damping_n_s_per_m: frequency_hz.map(|hertz| arm_impedance(&analysis.settings.arm, hertz).re),
        }
    }
}

/// A needed damping of `inf` means that no damping is enough.
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

/// Absolute stability over a parameter.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct AbsolutePart {
    /// Key of the parameter.
    parameter: &'static str,
    /// Values of the parameter, increasing.
    points: Vec<PointPart>,
}

/// Absolute stability at a value of a parameter.
#[derive(Debug, Serialize, JsonSchema)]
struct PointPart {
    /// Value, in the unit of the key.
    value: f64,
    /// Minimum of Llewellyn's parameter over frequency; the loop is absolutely stable from 1 on.
    min_llewellyn: Option<f64>,
    /// True if the loop is stable with any passive hand and tissue.
    is_absolutely_stable: bool,
    /// Needed damping of the hand with the tissues of the range, in N·s/m; `None` if no damping is enough.
    needed_hand_damping_n_s_per_m: Option<f64>,
    /// The frequency at which this damping is needed, in Hz.
    frequency_hz: Option<f64>,
    /// True if the loop is stable with every hand and tissue of the ranges.
    is_stable_with_ranges: Option<bool>,
}

impl AbsolutePart {
    pub(super) fn of(absolute: &AbsoluteOver) -> Self {
        let point = |point: &AbsolutePoint| PointPart {
            value: point.value,
            min_llewellyn: finite(point.min_llewellyn),
            is_absolutely_stable: point.is_absolutely_stable,
            needed_hand_damping_n_s_per_m: point.bounded.needed_damping().and_then(finite),
            frequency_hz: point.bounded.most().map(|most| most.frequency_hz),
            is_stable_with_ranges: point.bounded.is_stable(),
        };
        Self { parameter: absolute.parameter.key(), points: absolute.points.iter().map(point).collect() }
    }
}

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
