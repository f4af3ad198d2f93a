//! Absolute stability with bounded hands and tissues as CSV, JSON, text and figure.

use std::fmt::Write as _;

use serde_json::{Value as Json, json};

use super::Folder;
use super::figures::{self, AbsoluteView};
use super::number::significant;
use super::pictures::{PictureError, keep};
use super::tables::shortest;
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

/// Returns `hand_damping.csv`: the damping of a hand that is needed with the tissues of the range at each frequency, and
/// that of the scenario's arm.
#[must_use]
pub fn hand_damping_csv(analysis: &Analysis, bounded: &Bounded) -> String {
    let mut text = "frequency_hz,needed_n_s_per_m,arm_n_s_per_m\n".to_owned();
    for point in &bounded.needed {
        let arm = arm_impedance(&analysis.settings.arm, point.frequency_hz).re;
        let cells = [point.frequency_hz, point.damping_n_s_per_m, arm].map(shortest);
        let _ = writeln!(text, "{}", cells.join(","));
    }
    text
}

/// Returns a line about the hands and tissues of the ranges, ending with a newline; empty without a two-port.
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
    text + "\n"
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

/// The cells of a value: Llewellyn's parameter, verdict, needed damping with its frequency, verdict with the ranges.
fn cells(point: &AbsolutePoint) -> (Option<f64>, bool, Option<f64>, Option<f64>, Option<bool>) {
    let bounded = &point.bounded;
    (
        finite(point.min_llewellyn),
        point.is_absolutely_stable,
        bounded.needed_damping(),
        bounded.most().map(|most| most.frequency_hz),
        bounded.is_stable(),
    )
}

/// Returns `absolute.csv`: the absolute stability over a parameter. A needed damping of `inf` is more than any.
#[must_use]
pub fn absolute_csv(absolute: &AbsoluteOver) -> String {
    let key = absolute.parameter.key();
    let mut text = format!(
        "{key},min_llewellyn,is_absolutely_stable,needed_hand_damping_n_s_per_m,frequency_hz,is_stable_with_ranges\n"
    );
    for point in &absolute.points {
        let (llewellyn, absolutely, needed, hertz, stable) = cells(point);
        let number = |value: Option<f64>| value.map_or(String::new(), shortest);
        let verdict = stable.map_or(String::new(), |stable| u8::from(stable).to_string());
        let (llewellyn, needed, hertz) = (number(llewellyn), number(needed), number(hertz));
        let _ =
            writeln!(text, "{},{llewellyn},{},{needed},{hertz},{verdict}", shortest(point.value), u8::from(absolutely));
    }
    text
}

/// Returns the absolute stability over a parameter for `stability.json`.
pub(super) fn absolute_json(absolute: &AbsoluteOver) -> Json {
    let points = absolute.points.iter().map(|point| {
        let (llewellyn, absolutely, needed, hertz, stable) = cells(point);
        json!({
            "value": point.value,
            "min_llewellyn": llewellyn,
            "is_absolutely_stable": absolutely,
            "needed_hand_damping_n_s_per_m": needed.and_then(finite),
            "frequency_hz": hertz,
            "is_stable_with_ranges": stable,
        })
    });
    json!({ "parameter": absolute.parameter.key(), "points": points.collect::<Vec<_>>() })
}

/// Returns a line about the absolute stability over a parameter: up to which value it holds.
#[must_use]
pub fn absolute_text(absolute: &AbsoluteOver) -> String {
    let key = absolute.parameter.key();
    let unit = unit_of(key).map_or(String::new(), |unit| format!(" {unit}"));
    let up_to = |holds: &dyn Fn(&AbsolutePoint) -> bool| {
        let last = absolute.points.iter().take_while(|point| holds(point)).last();
        last.map_or("not at the first value".to_owned(), |point| format!("up to {}{unit}", significant(point.value)))
    };
    format!(
        "stable over {key}: with any passive hand and tissue {}, with those of the ranges {}\n",
        up_to(&|point| point.is_absolutely_stable),
        up_to(&|point| point.bounded.is_stable() == Some(true)),
    )
}

/// Writes the figure `absolute`.
///
/// # Errors
/// [`PictureError`].
pub fn absolute_picture(
    folder: &Folder,
    name: &str,
    analysis: &Analysis,
    absolute: &AbsoluteOver,
) -> Result<(), PictureError> {
    keep(folder, "absolute", &figures::absolute(&view(name, analysis, absolute))?)
}

/// What is drawn of the absolute stability over a parameter.
pub(super) fn view(name: &str, analysis: &Analysis, absolute: &AbsoluteOver) -> AbsoluteView {
    let most = |point: &AbsolutePoint| point.bounded.most();
    AbsoluteView {
        name: name.to_owned(),
        caption: absolute.parameter.caption().to_owned(),
        values: absolute.points.iter().map(|point| point.value).collect(),
        llewellyn: absolute.points.iter().map(|point| point.min_llewellyn).collect(),
        needed: absolute.points.iter().map(|point| point.bounded.needed_damping().unwrap_or(f64::NAN)).collect(),
        of_arm: absolute
            .points
            .iter()
            .map(|point| most(point).map_or(f64::NAN, |at| arm_impedance(&analysis.settings.arm, at.frequency_hz).re))
            .collect(),
    }
}
